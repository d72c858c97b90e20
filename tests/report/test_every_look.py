"""What a page shows of a study that is unfinished, was extended, or stops when it is decided."""

from dataclasses import replace

import pytest
from builders import SOLUTION, make_trial, small_study
from reported import found_in, tables_of

from lockprobe.report.page import Page
from lockprobe.report.questions.claims import not_judged
from lockprobe.report.questions.stopping import SECTIONS, small_said
from lockprobe.report.rows import Estimate
from lockprobe.studies.study import EarlierSize, Until

FAILED = (0, 1) * 10
ROWS = 40


def trials_of(blocks, *, without=()):
    """All truths are solved, and every fourth trial told lies."""
    return [
        make_trial(FAILED if p and n % 4 else SOLUTION, p=p, trial=n, agent="human-inspired")
        for n in range(1, blocks + 1)
        for p in (0.0, 0.4)
        if (p, n) not in without
    ]


def planned(trials=ROWS, **more):
    return replace(small_study(["human-inspired"], (0.0, 0.4), 1, trials), **more)


def said(found, kind):
    return found.fact("overview", kind)


EARLIER = EarlierSize(repetitions=1, trials=20, strategy_trials=None)
KINDS = {
    "": (planned(), ROWS),
    "unfinished": (planned(60), ROWS),
    "extended": (planned(earlier=(EARLIER,)), ROWS),
    "until": (planned(until=Until(rule="decided")), 20),
}


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    return {kind: found_in(tmp_path_factory.mktemp("page"), study, trials_of(n)) for kind, (study, n) in KINDS.items()}


@pytest.mark.parametrize("kind", KINDS)
def test_the_first_screen_says_for_how_many_looks_it_holds(pages, kind):
    found = pages[kind]
    assert found.progress.every_look == kind
    look = "at every look" if kind else "95 % intervals after all planned trials"
    assert look in Page(found=found).text()
    assert bool(said(found, "every_look")) == bool(kind)
    assert "False reports lower the success of human-inspired" in found.answer


def test_what_holds_at_every_look_is_wider_and_no_other_test_has_a_p_value(pages):
    once, always = pages[""], pages["extended"]
    sharp, wide = (found.one("success_difference", of="") for found in (once, always))
    assert sharp.value == wide.value == -0.75
    assert wide.low < sharp.low < sharp.high < wide.high < 0
    assert (sharp.test, wide.test) == ("permutation within blocks, and interval", "e-process")
    tested = {row.test for row in always.rows if row.p_value is not None}
    assert tested == {"e-process"}
    assert {row[6] for row in tables_of(always)["claims"][1:]} == {"not judged", "not measured"}
    assert not_judged(once) == ""
    assert "one look" in not_judged(always)


def test_an_extension_and_a_plan_to_stop_are_told_and_when_each_difference_was_decided(pages):
    told, found = said(pages["extended"], "every_look"), pages["until"]
    assert told.startswith("Trials were added to this study after it had begun. Success and")
    assert said(found, "every_look").startswith(
        "1 of 1 difference between conditions decided, with 40 of at most 80 trials."
    )
    assert found.progress.planned == found.progress.finished == 40
    assert not found.progress.partial
    (decided,) = found.where("decided_at_block")
    (curve,) = [one for one in found.curves if one.quantity == "difference_by_block"]
    at = curve.x.index(decided.value)
    assert decided.note == "an effect"
    assert curve.high[at] < 0 <= curve.high[at - 1]
    (part,) = SECTIONS[0].show(found)
    assert part.answer == "1 of 1 differences between conditions are decided."


def test_what_is_shown_to_be_small_goes_by_the_words_of_its_condition(pages):
    of = {"agent": "human-inspired", "of": "flip?p=0.4", "unit": "blocks", "value": 9, "note": "smaller than 10 points"}
    found = pages["until"].with_rows([Estimate(quantity="decided_at_block", **of)])
    said = "Shown to be smaller than 10 points, either way: effects of flip rate 0.4 on human-inspired."
    assert small_said(found) == said
    assert small_said(pages["until"]) == ""


def test_trials_behind_an_open_block_are_in_no_number(tmp_path):
    found = found_in(tmp_path, planned(60), trials_of(ROWS, without=[(0.4, 31)]))
    assert found.one("success_difference", of="").n == 30
    assert found.progress.not_counted == 9
    assert found.progress.finished == 79
