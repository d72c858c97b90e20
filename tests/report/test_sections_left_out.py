"""Whatever part of a report fails, the report is written, and says in every place what is missing and why."""

import html
import json
import sys
from dataclasses import replace

import pytest
from builders import write_study

from lockprobe.cli.report import report
from lockprobe.foundation import left_out as sections
from lockprobe.report import report_files
from lockprobe.report.opened import open_study
from lockprobe.report.parallel import one_thread
from lockprobe.report.questions import all_sections
from lockprobe.report.rows import Results
from lockprobe.report.verify.verification import verify
from lockprobe.report.write import write_report
from lockprobe.studies.options.studyfile import study

SAID = "broken on purpose"

ASKED = {
    "flips": {"agent": ["cognitive:careful", "cognitive:softmax-memory"], "p": [0, 0.4]},
    "conditions": {
        "agent": ["cognitive:careful"], "p": [0, 0.3, 0.6], "condition": ["nudge", "nudge + flip?p=0.6"], "name": "lab",
    },
}  # fmt: skip


@pytest.fixture(scope="module", params=list(ASKED))
def directory(request, tmp_path_factory):
    """A small study of flip rates, and one of conditions with a crossing and a series."""
    path = tmp_path_factory.mktemp(request.param) / "study"
    return write_study(path, study("flips", **ASKED[request.param], trials=3, repetitions=1))


def wrapped(monkeypatch, around):
    """Every call of :func:`lockprobe.foundation.left_out.section` goes through this function first."""
    all_sections()  # imports their modules
    real = sections.section
    for module in [*sys.modules.values()]:
        if getattr(module, "__name__", "").startswith("lockprobe") and vars(module).get("section") is real:
            monkeypatch.setattr(module, "section", around(real))


def report_of(opened, left_out=None):
    """The files of a report, none of which is written."""
    with one_thread():
        told = left_out or (lambda section: None)
        return dict(report_files.report_files(opened, tell=lambda said: None, left_out=told, each=map))


def names(monkeypatch, opened):
    """What the sections of a report are called -> what was made before: nothing, numbers, results; and the numbers."""
    called, made = {}, []
    with monkeypatch.context() as patched:
        wrapped(patched, lambda real: lambda name, *make: (called.setdefault(name, len(made)), real(name, *make))[1])
        for name in ("StudyNumbers", "results_of"):
            real = getattr(report_files, name)
            patched.setattr(
                report_files, name, lambda *given, real=real, **each: made.append(real(*given, **each)) or made[-1]
            )
        report_of(opened)
    return called, made[0]


def broken(*_):
    raise RuntimeError(SAID)


def without(monkeypatch, opened, *missing, numbers=None):
    """The page, the results and what was told of a report in which these sections raise.

    Args:
        numbers: The numbers of the study, if no section fails on which they rest.
    """
    told = []
    with monkeypatch.context() as patched:
        wrapped(
            patched,
            lambda real: lambda name, make, instead: real(name, broken if name in missing else make, instead),
        )
        if numbers:
            patched.setattr(report_files, "StudyNumbers", lambda **asked: replace(numbers))
        files = report_of(opened, told.append)
    return html.unescape(files["report.html"]), Results.model_validate_json(files["results.json"]), told


def groups(called):
    """Names of what fails together: a section with its tables and figures, all parts of pages; the others alone."""
    sections = [
        (of.title, *(f"Table {one.name}" for one in of.tables), *(f"Figure {one.name}" for one in of.figures))
        for of in all_sections()
    ]
    shown = [{*names} & {*called} for names in sections]
    rest = {*called}.difference(*shown)
    parts = {name for name in rest if called[name] == 2 and not name.startswith("Page ")}
    return [*filter(None, shown), parts, *({name} for name in called if called[name] == 0 or name in rest - parts)]


def bundles(turns):
    """The same, four that lie far apart at once; what holds others, whose failure would hide theirs, fails alone."""
    held = [group for group in turns if any(name.startswith(("All numbers", "Page ")) for name in group)]
    free = [group for group in turns if group not in held]
    apart = -(-len(free) // 4)
    return [*held, *(set().union(*free[start::apart]) for start in range(apart))]


def test_each_section_in_turn_raises_and_the_report_is_written(monkeypatch, tmp_path):
    """In a study of conditions with two agents, and what one of flip rates has beside it."""
    asked = {name: value | {"trials": 2, "repetitions": 1, "max_steps": 10} for name, value in ASKED.items()}
    both = {**asked["conditions"], "agent": asked["flips"]["agent"], "p": [0, 0.6]}
    opened, flips = (
        open_study(write_study(tmp_path / name, study("flips", **given)))
        for name, given in (("conditions", both), ("flips", asked["flips"]))
    )
    (called, numbers), (also, _) = (names(monkeypatch, one) for one in (opened, flips))
    assert {"First screen", "Loops", "Hypothesis tests", "Design", "Trial explorer"} <= {*called}
    assert "" not in called
    turns = groups(called)
    assert len(turns) > 60
    assert len({*called}) == len({name for group in turns for name in group}) > 120
    more = [{name} for name in also if name not in called]
    assert len(more) < 5
    for of, group in [*((opened, group) for group in bundles(turns)), *((flips, group) for group in more)]:
        late = of is opened and all(called[name] for name in group)
        text, found, told = without(monkeypatch, of, *group, numbers=numbers if late else None)
        for name in group:
            assert any(one.section.startswith(name) and one.reason == f"RuntimeError: {SAID}" for one in told), name
        for one in told:
            assert f"{one.section} ({one.reason})" in text, group
        assert sorted((one.section, one.reason) for one in found.sections_left_out) == sorted(
            (one.section, one.reason) for one in told
        )
        assert "</html>" in text


def test_a_whole_report_leaves_nothing_out(directory):
    told = []
    text = write_report(directory, left_out=told.append).read_text("utf-8")
    assert told == []
    assert "Left out, because" not in text
    assert "sections_left_out" not in json.loads((directory / "results.json").read_text("utf-8"))


def box_breaks(patch):
    """The figure of the box cannot be drawn."""
    real = report_files.drawn_figure
    patch.setattr(report_files, "drawn_figure", lambda found, one: broken() if one.name == "box" else real(found, one))


def test_a_figure_that_cannot_be_drawn_is_left_out_of_its_page(monkeypatch, directory):
    box_breaks(monkeypatch)
    text = write_report(directory).read_text("utf-8")
    assert f"Figure box (RuntimeError: {SAID})" in text
    assert not (directory / "figures" / "box.svg").exists()
    assert (directory / "figures" / "fig4.svg").exists()


def test_no_answer_stands_where_its_numbers_are_missing(monkeypatch, directory):
    """Without numbers the trials seem to be none; the first screen must not say so."""
    opened = open_study(directory)
    text, found, _ = without(monkeypatch, opened, "All conditions")
    assert found.answer.startswith("The answer could not be computed")
    assert "No trial has ended yet" not in text


def test_the_line_of_the_report_names_what_is_missing(monkeypatch, directory, capsys):
    real = report_files.explorer_data
    monkeypatch.setattr(
        report_files, "explorer_data", lambda trials, box, **of: real(trials, box) if not trials else broken()
    )
    report([directory])
    said = capsys.readouterr().out.splitlines()[0]
    assert said.endswith(f"report.html, without Trial explorer (RuntimeError: {SAID})")
    report([directory], json=True)
    (line,) = capsys.readouterr().out.splitlines()
    assert json.loads(line)["left_out"] == [{"section": "Trial explorer", "reason": f"RuntimeError: {SAID}"}]


def test_verification_says_that_a_report_without_a_figure_is_to_be_written_again(monkeypatch, directory):
    """The records are whole, and so are the numbers; the page is not."""
    with monkeypatch.context() as patched:
        box_breaks(patched)
        write_report(directory)
    fails = {check.name: check.said for check in verify(directory) if not check.holds}
    assert "results" in fails
    assert all(
        said.endswith("without sections that can be made here: lockprobe report first") for said in fails.values()
    )
