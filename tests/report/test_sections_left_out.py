"""Whatever part of a report fails, the report is written, and says in every place what is missing and why."""

import html
import sys

import pytest
from builders import write_study
from threadpoolctl import threadpool_limits

from lockprobe.report import left_out as sections
from lockprobe.report import page
from lockprobe.report.opened import open_study
from lockprobe.report.questions import all_sections
from lockprobe.report.results import ONE_THREAD
from lockprobe.report.rows import Results
from lockprobe.studies.options.studyfile import study

SAID = "broken on purpose"
AGENTS = ["cognitive:careful", "cognitive:softmax-memory"]
SMALL = {"agent": AGENTS, "trials": 2, "repetitions": 1}


def broken(*_):
    raise RuntimeError(SAID)


def report_of(monkeypatch, directory, missing=()):
    """The page, the results and what was told of a report in which these sections raise; the names of all sections."""
    all_sections()  # imports their modules
    real, called, told, opened = sections.section, {}, [], open_study(directory)

    def instead(name, make, instead):
        called[name] = None
        return real(name, broken if name in missing else make, instead)

    with monkeypatch.context() as patched, threadpool_limits(ONE_THREAD):
        for module in [*sys.modules.values()]:
            if getattr(module, "__name__", "").startswith("lockprobe") and vars(module).get("section") is real:
                patched.setattr(module, "section", instead)
        files = dict(page.report_files(opened, tell=lambda said: None, left_out=told.append))
    return html.unescape(files["report.html"]), Results.model_validate_json(files["results.json"]), told, [*called]


def test_each_section_in_turn_raises_and_the_report_is_written(monkeypatch, tmp_path):
    """In a study of conditions with two agents, and what one of flip rates has beside it."""
    crossed, short = {"condition": ["nudge", "nudge + flip?p=0.6"], "name": "lab"}, {"max_steps": 10, **SMALL}
    both = write_study(tmp_path / "conditions", study("flips", **short, **crossed, p=[0, 0.6]))
    flips = write_study(tmp_path / "flips", study("flips", **short, p=[0, 0.4]))
    (*_, called), (*_, also) = (report_of(monkeypatch, one) for one in (both, flips))
    assert {"First screen", "Action loops", "Design", "The answer", "Figure fig3", "Trial explorer"} <= {*called}
    assert len(called) > 60
    more = [{name} for name in also if name not in called]
    asked = {name for name in called if name.endswith("?") or name.startswith("One trial")}  # headings fail alone
    free = [name for name in called if name not in asked]
    apart = [asked, *({*free[start::6]} for start in range(6))]  # names that lie far apart fail together
    for of, names in [*((both, names) for names in apart), *((flips, names) for names in more)]:
        text, found, told, _ = report_of(monkeypatch, of, names)
        for name in names:
            assert any(one.section.startswith(name) and one.reason == f"RuntimeError: {SAID}" for one in told), name
        for one in told:
            assert f"{one.section} ({one.reason})" in text, names
        assert sorted((one.section, one.reason) for one in found.sections_left_out) == sorted(
            (one.section, one.reason) for one in told
        )
        assert "</html>" in text
        assert (found.answer == "") == ("The answer" in names)


def dividing():
    raise ZeroDivisionError("division\nby zero")


def test_a_section_that_fails_is_replaced_and_named_once_in_a_short_line():
    def long():
        raise ValueError("x" * 1000 + "\n\x1b[2J")

    class Mute(Exception):
        def __str__(self):
            raise TypeError

    def mute():
        raise Mute

    with sections.leaving_out() as failed:
        assert sections.section("Loops", lambda: 1, lambda: 2) == 1
        for _ in range(2):
            assert sections.section("Loops", dividing, lambda: 2) == 2
        sections.section("Lengths", long, lambda: None)
        sections.section("Words", mute, lambda: None)
    assert failed[0] == sections.LeftOutSection("Loops", "ZeroDivisionError: division by zero")
    assert [one.reason.isprintable() and len(one.reason) <= 200 for one in failed] == [True] * 3
    assert failed[2].reason == "Mute"


def test_where_nobody_collects_an_error_is_raised_and_an_interrupt_always():
    with pytest.raises(ZeroDivisionError):
        sections.section("Loops", dividing, lambda: 2)

    def interrupted():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), sections.leaving_out():
        sections.section("Loops", interrupted, lambda: 2)
