"""The sentence says what the verdict is, with the numbers that it rests on."""

from dataclasses import replace

import pytest
from why_answers import answer, with_arms

from lockprobe.prose.why import mechanism_said, why_said


@pytest.mark.parametrize(
    ("found", "said"),
    [
        (answer(0.3, 0), "raise the success of cognitive:insistent because of what they say."),
        (answer(-0.15, 0), "lower the success of cognitive:insistent because of what they say."),
        (answer(0, 0.3), "because they disturb, not because of what they say."),
        (answer(0.2, 0.2), "for two reasons: what they say, and that they disturb."),
        (answer(0.4, -0.15), "what they say raises it, that they disturb lowers it."),
        (answer(0.04, 0.04), "neither what they say nor that they disturb is detectable as the reason."),
        (answer(0, 0, equivalence=0.01), "do not change the success of cognitive:insistent by 10 points or more."),
        (answer(0, 0), "Neither a change by false reports in the success of cognitive:insistent is detectable"),
    ],
)
def test_every_verdict_has_its_sentence(found, said):
    assert said in mechanism_said(found)


def test_the_numbers_follow():
    _, numbers = why_said(answer(0.3, 0))
    assert numbers == (
        "20 % of trials were solved under true reports, 50 % where reports were inverted at a rate of 0.4: +30 points "
        "(95 % interval +25 to +35; P = 0.001). With lies that are taken back at once it is 20 %. So the disturbance "
        "alone does +0 points (95 % interval \N{MINUS SIGN}5 to +5; P = 0.6), and what lies say +30 points (95 % "
        "interval +25 to +35; P = 0.001)."
    )


def test_what_is_open_says_what_would_decide_it():
    said = why_said(answer(0, 0))
    assert "either way give P = 0.5" in said[2]
    assert "about 230 blocks" in said[3]
    assert said[3].endswith("there are 150.")


def test_what_else_changes_success_is_named_without_a_mechanism():
    said = why_said(answer(0, 0.3, others=("withheld", "tremble")))
    assert said[2].startswith("Other changes at the same steps also raise success: withheld +20 points")
    assert "; tremble +20 points" in said[2]
    assert len(said) == 3
    assert len(why_said(answer(-0.15, 0, others=("withheld", "tremble")))) == 2


def test_what_only_an_uncorrected_interval_shows_is_not_named():
    found = answer(0, 0.3, others=("withheld",))
    *rest, last = found.arms
    unsure = replace(last, change=replace(last.change, p_value=0.2))
    assert last.change.clear
    assert len(why_said(with_arms(found, (*rest, unsure)))) == 2
