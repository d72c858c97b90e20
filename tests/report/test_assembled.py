"""Whatever part of a report fails, the report is written, and says in every place what is missing and why."""

import html
import json
import sys

import pytest
from builders import write_study

from lockprobe import sections
from lockprobe.cli.report import report
from lockprobe.report import page, study_rows, write_report
from lockprobe.report.opened import open_study
from lockprobe.report.page import report_files
from lockprobe.report.parallel import one_thread
from lockprobe.report.verification import verify
from lockprobe.studies.studyfile import study

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


@pytest.fixture
def undrawn(monkeypatch):
    """For speed: of the figures that of the box, drawn once, and of the audit two worlds stand for all."""
    real, drawn = page.study_drawings, {}
    audit = study_rows.shipped()
    worlds = {name: audit["worlds"][name] for name in ("no-effect", "people")}
    rates = [rate for rate in audit["rates"] if rate["world"] in worlds]
    monkeypatch.setattr(study_rows, "shipped", lambda: audit | {"worlds": worlds, "rates": rates})

    def box(*given):
        return lambda: drawn.get("box") or drawn.setdefault("box", real(*given)["box"]())

    monkeypatch.setattr(page, "study_drawings", lambda *given: {"box": box(*given)})


def wrapped(monkeypatch, around):
    """Every call of :func:`lockprobe.sections.section` goes through this function first."""
    real = sections.section
    for module in [*sys.modules.values()]:
        if getattr(module, "__name__", "").startswith("lockprobe") and vars(module).get("section") is real:
            monkeypatch.setattr(module, "section", around(real))


def report_of(opened, left_out=None):
    """The files of a report, none of which is written."""
    with one_thread():
        told = left_out or (lambda section: None)
        return dict(report_files(opened, tell=lambda said: None, left_out=told, each=map))


def names(monkeypatch, opened):
    """What every section of a report is called, in the order in which they are made."""
    found = {}
    with monkeypatch.context() as patched:
        wrapped(
            patched, lambda real: lambda name, make, instead: (found.setdefault(name), real(name, make, instead))[1]
        )
        report_of(opened)
    return list(found)


def broken():
    raise RuntimeError(SAID)


def without(monkeypatch, opened, name):
    """The page, the results and what was told of a report in which one section raises."""
    told = []
    with monkeypatch.context() as patched:
        wrapped(
            patched,
            lambda real: lambda title, make, instead: real(title, broken if title.startswith(name) else make, instead),
        )
        files = report_of(opened, told.append)
    return html.unescape(files["report.html"]), json.loads(files["results.json"]), told


def test_each_section_in_turn_raises_and_the_report_is_written(monkeypatch, undrawn, tmp_path):
    """In a study of conditions with two agents, and what one of flip rates has beside it."""
    asked = {name: value | {"trials": 3, "repetitions": 1} for name, value in ASKED.items()}
    both = {**asked["conditions"], "agent": asked["flips"]["agent"], "p": [0, 0.6]}
    opened, flips = (
        open_study(write_study(tmp_path / name, study("flips", **given)))
        for name, given in (("conditions", both), ("flips", asked["flips"]))
    )
    everything = names(monkeypatch, opened)
    assert len(everything) > 40
    more = [name for name in names(monkeypatch, flips) if name not in everything]
    assert len(more) < 5
    assert {"First screen", "Findings", "Loops", "Hypothesis tests", "Design", "Trial explorer"} <= {*everything}
    for of, name in [*((opened, name) for name in everything), *((flips, name) for name in more)]:
        text, content, told = without(monkeypatch, of, name)
        ours = [one for one in told if one.section.startswith(name) and one.reason == f"RuntimeError: {SAID}"]
        assert ours, name
        for one in told:
            assert f"{one.section} ({one.reason})" in text, name
        assert content["sections_left_out"] == [{"section": one.section, "reason": one.reason} for one in told], name
        assert "</html>" in text


def test_a_whole_report_leaves_nothing_out(undrawn, directory):
    told = []
    text = write_report(directory, left_out=told.append).read_text("utf-8")
    assert told == []
    assert "Left out, because" not in text
    assert "sections_left_out" not in json.loads((directory / "results.json").read_text("utf-8"))


def test_a_figure_that_cannot_be_drawn_is_left_out_of_its_page(monkeypatch, directory):
    monkeypatch.setattr(page, "study_drawings", lambda *_: {"box": broken})
    text = write_report(directory).read_text("utf-8")
    assert f"Figure box (RuntimeError: {SAID})" in text
    assert not (directory / "figures" / "box.svg").exists() or "box.svg" not in text


def test_no_answer_stands_where_its_numbers_are_missing(monkeypatch, undrawn, directory):
    """Without numbers the trials seem to be none; the first screen must not say so."""
    text, content, _ = without(monkeypatch, open_study(directory), "All numbers of")
    assert content["overview"]["answer"].startswith("The answer could not be computed")
    assert "No trial has ended yet" not in text


def test_the_last_line_names_what_is_missing(monkeypatch, undrawn, directory, capsys):
    monkeypatch.setattr(
        "lockprobe.report.page.explorer_data",
        lambda trials, box, real=page.explorer_data: real(trials, box) if not trials else broken(),
    )
    report(directory)
    assert capsys.readouterr().out.strip().endswith(f"report.html, without Trial explorer (RuntimeError: {SAID})")
    report(directory, json=True)
    (line,) = capsys.readouterr().out.splitlines()
    assert json.loads(line)["left_out"] == [{"section": "Trial explorer", "reason": f"RuntimeError: {SAID}"}]


def test_verification_says_that_a_report_without_a_figure_is_to_be_written_again(monkeypatch, directory):
    """The records are whole, and so are the numbers; the page is not."""
    with monkeypatch.context() as patched:
        patched.setattr(page, "study_drawings", lambda *_: {"box": broken})
        write_report(directory)
    (fails,) = [check for check in verify(directory) if not check.holds]
    assert fails.name == "results"
    assert fails.said.endswith("without sections that can be made here: lockprobe report first")
