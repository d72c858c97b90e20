"""Conditions: what each changes, doses, factors, levels and grids, as rows and as sentences."""

import pytest
from reported import found_in, tables_of

from lockprobe.foundation.formatting import p_cell
from lockprobe.report.format import beside, entry_text
from lockprobe.report.page import parts_of
from lockprobe.report.prose import condition_words
from lockprobe.report.questions.conditions import EFFECTS
from lockprobe.studies.options.studyfile import study

READER = "cognitive:perseverant"
LAB = {
    "agent": [READER, "random"], "p": [0, 0.3, 0.6], "sweep": "tremble?p=0.1,0.2,0.4",
    "condition": ["nudge", "nudge + flip?p=0.6"], "trials": 8, "repetitions": 1,
}  # fmt: skip
GRID = {
    "agent": ["human-inspired", "random"], "sweep": "flip?p=0,0.2,0.4 + tremble?p=0,0.1,0.4", "trials": 6,
    "repetitions": 1,
}  # fmt: skip
AXIS = "flip rate \N{MULTIPLICATION SIGN} tremble p"


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    """A study of eight conditions."""
    return found_in(tmp_path_factory.mktemp("lab"), study("flips", **LAB))


@pytest.fixture(scope="module")
def grid(tmp_path_factory):
    """A study of crossed doses."""
    return found_in(tmp_path_factory.mktemp("grid"), study("flips", **GRID))


def test_what_is_crossed_has_one_interaction_and_a_grid_one_over_all_its_cells(lab, grid):
    both = "nudge \N{MULTIPLICATION SIGN} flip?p=0.6"
    assert [row.value for row in lab.where("success_interaction")] == [0, 0]  # neither agent reads words
    assert [row[:2] for row in tables_of(lab)["crossings"][1:]] == [[READER, both], ["random", both]]
    (part,) = [part for part in parts_of(lab) if part.name == "crossings"]
    assert (part.heading, part.answer) == ("Interactions", "0 of 2 interactions detected.")
    first, random = grid.where("success_interaction", versus="")
    assert (first.axis, first.condition, random.value, random.p_value) == (AXIS, "", 0, 1)
    assert random.corrected_for == 2  # agents
    _, *rows = tables_of(grid)["crossings"]
    assert [row[1] for row in rows] == [AXIS] * 2
    facts = grid.facts_about(AXIS)
    doses = {one.name: (one.doses.get("flip.p", 0), one.doses.get("tremble.p", 0)) for one in grid.design.conditions}
    assert {*facts} == {"{:g}, {:g}".format(*both) for both in doses.values()}
    assert all(facts["{:g}, {:g}".format(*both)] == name for name, both in doses.items())
    (part,) = [part for part in parts_of(grid) if part.name == "crossings"]
    head, *rows = part.blocks[0].cells(grid)
    assert head == ["agent", "flip rate", "tremble p 0", "tremble p 0.1", "tremble p 0.4"]
    assert [row[:2] for row in rows] == [[agent, dose] for agent in GRID["agent"] for dose in ("0", "0.2", "0.4")]
    assert rows[2][3] is grid.one("success", agent="human-inspired", condition=facts["0.4, 0.1"], control="", axis="")


def test_the_table_has_every_condition_and_what_each_changes_and_the_answer_counts_what_was_detected(lab):
    words = condition_words(lab)
    assert words["flip?p=0.3"] == "flip rate 0.3"
    head, *rows = tables_of(lab)["conditions"]
    at = [head.index(name) for name in ("change, points", "P")]
    compared = {(row.agent, words[row.condition]): row for row in lab.against_control()}
    known = dict.fromkeys((cell.agent, words[cell.condition]) for cell in lab.cells if not cell.blind)
    assert [(row[0], row[1]) for row in rows if row[1] != "every flip rate"] == [*known]
    for row in rows:
        change = compared.pop((row[0], row[1]), None)
        if change:
            of = {"agent": change.agent, "control": "", "versus": ""}
            change = beside(
                change, *(lab.get("success", condition=one, **of) for one in (change.control, change.condition))
            )
        assert [row[i] for i in at] == [entry_text(change), p_cell(change.p_value if change else None)]
    assert compared == {}
    assert [row[5] for row in EFFECTS.cells(lab)[1:]] == lab.against_control()
    (part,) = [part for part in parts_of(lab) if part.name == "conditions"]
    detected = [row.detected for row in lab.against_control()]
    said = f"{sum(detected)} of {len(detected)} changes of an agent under a condition detected."
    assert part.answer == said


def test_readings_are_compared_in_pairs_at_the_same_rate(tmp_path):
    asked = {"agent": [READER, "random"], "p": [0, 0.4, 0.6], "flip": "re-observed,integrated", "trials": 20, "seed": 3}
    found = found_in(tmp_path, study("flips", **asked, condition="no-feedback=drop?p=1", repetitions=1))
    head, *rows = tables_of(found)["effects"]
    effects = [dict(zip(head, row, strict=True)) for row in rows]
    shown = [row for row in effects if row["agent"] == READER and row["control"].startswith("flip")]
    assert [(row["condition"], row["control"]) for row in shown] == [
        (f"flip rate {rate}, false reports that stay", f"flip rate {rate}") for rate in ("0.4", "0.6")
    ]
    gap = found.one("success_difference", agent=READER, condition="flip?p=0.4&others=kept", control="flip?p=0.4")
    assert shown[0]["difference, points"] == entry_text(gap)
    kept, fresh = (
        found.one("success", agent=READER, condition=name) for name in ("flip?p=0.4&others=kept", "flip?p=0.4")
    )
    assert gap.value == pytest.approx(kept.value - fresh.value)
    assert found.where("success_difference", agent="random", control="flip?p=0.4") == []  # it plays alike


# A condition that changed nothing is no null result: it is in no comparison, and is named.


def results_of(directory, *conditions, agents=("human-inspired",)):
    asked = {"trials": 12, "repetitions": 1, "condition": list(conditions), "agent": list(agents), "p": [0]}
    return found_in(directory, study("flips", **asked))


def compared(results):
    """The agents and conditions whose success is compared with that of the control."""
    return {(row.agent, row.condition) for row in results.where("success_difference") if row.control}


@pytest.mark.parametrize("acts", ["history?last=50", "flip?p=1&at=20", "nudge?after=6", "hypothesis"])
def test_a_condition_that_changed_nothing_is_compared_with_nothing_and_named(tmp_path, acts):
    results = results_of(tmp_path, acts, "flip?p=0.4")
    (cell,) = (one for one in results.cells if one.condition == acts)
    assert [row.condition for row in results.where("success", of="") if row.note == "never acted"] == [acts]
    assert compared(results) == {("human-inspired", "flip?p=0.4")}
    assert cell.value("steps", "changed") == 0
    said = f"{acts} changed nothing (0 of {cell.value('steps'):g} steps), so nothing is concluded from it."
    assert said in " ".join(one.text for one in results.facts)


def test_where_no_condition_changed_anything_that_is_the_answer(tmp_path):
    acts = "history?last=50"
    results = results_of(tmp_path, acts, agents=("human-inspired", "round-robin"))
    steps = sum(cell.value("steps") for cell in results.cells if cell.condition == acts)
    said = f"{acts} changed nothing for any agent (0 of {steps:g} steps), so nothing is concluded from it."
    assert (results.answer, compared(results)) == (said, set())
