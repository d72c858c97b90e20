"""A study of conditions end to end: from records to files, exports and fits, and what is said of what never acted."""

from dataclasses import dataclass, replace

import pytest
from builders import write_study

from lockprobe.report.page import figures_of, parts_of
from lockprobe.report.rows import Results
from lockprobe.report.write import write_report
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.read_records import load

ASKED = {
    "agent": ["cognitive:perseverant", "random"], "p": [0, 0.3, 0.6], "sweep": "tremble?p=0.1,0.2,0.4",
    "condition": ["nudge", "nudge + flip?p=0.6"], "trials": 8, "repetitions": 2, "name": "lab",
}  # fmt: skip
SMALL = {"p": [0], "trials": 6, "repetitions": 1}
REAL = ("fig3", "series-1-success")


def reported_in(directory, played=None, **asked):
    """The directory of a study with its report, the page, and the results as they are on disk."""
    directory = write_study(directory / "study", study("flips", **asked), played)
    page = write_report(directory).read_text()
    return directory, page, Results.model_validate_json((directory / "results.json").read_bytes())


@pytest.fixture(scope="module")
def reported(tmp_path_factory, drawn):
    """A study of eight conditions."""
    with drawn(*REAL):
        return reported_in(tmp_path_factory.mktemp("lab"), **ASKED)


def test_every_agent_has_the_counts_of_its_records_under_every_condition(reported):
    directory, _, found = reported
    labels = [
        "truth", "flip?p=0.3", "flip?p=0.6", "nudge", "nudge + flip?p=0.6",
        "tremble?p=0.1", "tremble?p=0.2", "tremble?p=0.4",
    ]  # fmt: skip
    cells = {(cell.agent, cell.condition): cell for cell in found.cells}
    assert [*cells] == [(agent, label) for agent in ASKED["agent"] for label in labels]
    assert [one.p for one in found.design.conditions] == [0, 0.3, 0.6, *[None] * 5]
    solved = {name: [] for name in cells}
    for trial in load(directory):
        solved[trial.agent, trial.condition].append(trial.solved)
    for name, cell in cells.items():
        assert (cell.trials, cell.get("success").count) == (16, sum(solved[name]))
        assert len(solved[name]) == 16


def test_every_figure_stands_on_its_page_and_among_the_files(reported):
    directory, page, found = reported
    for name in REAL:
        assert (directory / "figures" / f"{name}.svg").read_bytes().startswith(b"<?xml")
    shown = {one.name for one in figures_of(parts_of(found)) if one.applies(found)}
    assert {*REAL} < shown
    assert shown <= {path.stem for path in (directory / "figures").iterdir()}
    assert page.count("<img") == len(shown)


def test_equal_records_make_equal_files(reported, drawn):
    directory, _, _ = reported
    before = {path: path.read_bytes() for path in directory.rglob("*") if path.is_file()}
    with drawn(*REAL):
        write_report(directory)
    assert before == {path: path.read_bytes() for path in directory.rglob("*") if path.is_file()}


@dataclass(frozen=True, kw_only=True)
class OutcomeAlone:
    """Says the opposite outcome, and leaves positions as they are: no report of states shows that."""

    def perceive(self, percept, past, task, rng):
        return percept if percept.joint is None else replace(percept, outcome="moved")


def never_acted(found, condition):
    """The cells in which a condition changed nothing, and what is said of those of these agents."""
    idle = [cell for cell in found.cells if cell.condition == condition and cell.get("success").note == "never acted"]
    assert {cell.value("steps", of) for cell in idle for of in ("changed", f"changed by {condition}")} == {0}

    def said(agents):
        steps = sum(cell.value("steps") for cell in idle if cell.agent in agents)
        return f"{condition} changed nothing for any agent (0 of {steps:g} steps), so nothing is concluded from it."

    return {cell.agent for cell in idle}, said


def test_a_condition_that_changed_nothing_is_the_answer_and_has_no_effect(tmp_path):
    acts, agents = f"python:{__name__}:OutcomeAlone", {"human-inspired", "round-robin"}
    _, page, found = reported_in(tmp_path, agent=[*agents], condition=acts, **SMALL)
    idle, said = never_acted(found, acts)
    assert idle == agents
    assert found.answer == said(agents)
    assert not [row for row in found.rows if row.control]
    assert "No effect" not in page
    assert "No difference from" not in page


def test_beside_a_condition_that_changed_nothing_only_the_other_ones_are_concluded_from(tmp_path):
    """A baseline's is named too, though nothing is said of its effects."""
    agents, acts = ["cognitive:careful", "cognitive:insistent", "random"], ["history?last=50", "distract?p=0.3"]
    _, page, found = reported_in(tmp_path, agent=agents, condition=acts, **SMALL)
    idle, said = never_acted(found, acts[0])
    assert idle == {*agents}
    assert {row.condition for row in found.rows if row.control} == {acts[1]}
    assert "o effect of any other condition on the success of" in found.answer
    assert "any condition" not in page
    (on_top,) = found.said("overview", "changed_nothing")
    assert said(agents[:2]) in on_top
