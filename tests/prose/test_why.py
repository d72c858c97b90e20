"""The sentence says what the verdict is, with the numbers that it rests on."""

from dataclasses import replace

import pytest
from why_answers import answer, with_arms

from lockprobe.prose.why import mechanism_said, why_said


@pytest.mark.parametrize(
    ("found", "said"),
    [
        (answer(0.3, 0), "raise the success of cognitive:insistent through their content."),
        (answer(-0.15, 0), "lower the success of cognitive:insistent through their content."),
        (answer(0, 0.3), "through the disturbance; no effect of their content was detected."),
        (answer(0.2, 0.2), "in two ways: through their content and through the disturbance."),
        (answer(0.4, -0.15), "their content raises it, the disturbance lowers it."),
        (answer(0.04, 0.04), "neither an effect of their content nor of the disturbance was detected."),
        (answer(0, 0, equivalence=0.01), "change the success of cognitive:insistent by less than 10 points."),
        (answer(0, 0), "Inconclusive: no effect of false reports on the success of cognitive:insistent was detected"),
    ],
)
def test_every_verdict_has_its_sentence(found, said):
    assert said in mechanism_said(found)


def test_the_numbers_follow():
    _, numbers = why_said(answer(0.3, 0))
    assert numbers == (
        "20 % of trials were solved with true reports, 50 % with reports inverted at a rate of 0.4: +30 points "
        "(95 % interval +25 to +35; P = 0.001). With false reports that are corrected at once it is 20 %. So the effect "
        "of the disturbance is 0 points (95 % interval \N{MINUS SIGN}5 to +5; P = 0.6), and the effect of the content "
        "+30 points (95 % interval +25 to +35; P = 0.001)."
    )


def test_what_is_open_says_what_would_decide_it():
    said = why_said(answer(0, 0))
    assert "in either direction give P = 0.5" in said[2]
    assert "About 230 blocks" in said[3]
    assert said[3].endswith("this study has 150.")


def test_what_else_changes_success_is_named_without_a_mechanism():
    said = why_said(answer(0, 0.3, others=("withheld", "tremble")))
    assert said[2].startswith("Other interventions at the same steps also raise success: withheld +20 points")
    assert "; tremble +20 points" in said[2]
    assert len(said) == 3
    assert len(why_said(answer(-0.15, 0, others=("withheld", "tremble")))) == 2


def test_of_several_agents_it_says_for_how_many_its_numbers_are_corrected():
    said = "P values and intervals of differences are corrected for 10 agents (Bonferroni)."
    assert why_said(answer(0.3, 0, agents=10))[-1] == said
    assert not any("corrected for" in one for one in why_said(answer(0.3, 0)))


def test_what_only_an_uncorrected_interval_shows_is_not_named():
    found = answer(0, 0.3, others=("withheld",))
    *rest, last = found.arms
    unsure = replace(last, change=replace(last.change, p_value=0.2))
    assert last.change.clear
    assert len(why_said(with_arms(found, (*rest, unsure)))) == 2
