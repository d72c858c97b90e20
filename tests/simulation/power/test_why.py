"""Verdicts on stated effects are right and wrong as often as they should be."""

import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.simulation.power.why import STATED, due, right, why_power, wrong
from lockprobe.statistics.why.mechanism import MARGIN


@pytest.mark.parametrize(
    ("truth", "total", "are_right", "are_wrong"),
    [
        ("says", 0.3, {"says"}, {"form", "both", "no change"}),
        ("says", -0.05, {"says", "no change"}, {"form", "both"}),
        ("both", 0.3, {"both"}, {"no change"}),
        ("blurred", 0.3, {"blurred"}, {"says", "form", "both", "no change"}),
        ("not decided", MARGIN, {"not decided"}, {"says", "form", "both", "no change"}),
        ("no change", 0, {"no change"}, {"says", "form", "both", "blurred", "not decided"}),
    ],
)
def test_what_is_right_and_what_is_wrong(truth, total, are_right, are_wrong):
    verdicts = ("says", "form", "both", "blurred", "not decided", "no change", "inconclusive")
    assert {one for one in verdicts if right(one, truth, total)} == are_right
    assert {one for one in verdicts if wrong(one, truth, total)} == are_wrong


@pytest.mark.parametrize(
    ("shares", "verdict"),
    [
        ((0.2, 0.7, 0.2, 0.7, 0.7, 0.7, 0.2), "says"),
        ((0.7, 0.2, 0.7, 0.7, 0.2, 0.2, 0.7), "says"),
        ((0.2, 0.7, 0.7, 0.7, 0.7, 0.7, 0.2), "blurred"),
        ((0.2, 0.7, 0.2, 0.2, 0.2, 0.2, 0.7), "not decided"),
        ((0.2, 0.7, 0.2, 0.7, 0.7, 0.2, 0.2), "not decided"),
        ((0.2, 0.7, 0.4, 0.4, 0.7, 0.7, 0.4), "both"),
        ((0.2, 0.7, 0.7, 0.4, 0.4, 0.7, 0.7), "form"),
        ((0.2, 0.2, 0.7, 0.4, 0.4, 0.7, 0.7), "no change"),
    ],
)
def test_what_is_true_of_stated_shares(shares, verdict):
    assert due(shares) == verdict


def test_stated_effects_are_told_and_chance_errors_keep_to_their_level():
    """With arms that share no luck the verdict errs in at most 5 % of studies, three standard errors aside."""
    for name, shares in STATED.items():
        small, large = why_power(name, shares, blocks=[20, 400], studies=60)
        assert max(small.wrong, large.wrong) <= 0.05 + 3 * (0.05 * 0.95 / 60) ** 0.5
        assert small.change == shares[1] - shares[0]
        if small.truth != "no change":
            assert large.right > 0.85
            assert large.claims


@pytest.mark.parametrize(("shares", "blocks"), [((0.2, 0.5), [50]), ((0.2,) * 6 + (1.5,), [50]), ((0.2,) * 7, [1])])
def test_effects_that_are_none_are_refused(shares, blocks):
    with pytest.raises(BadValue):
        why_power("x", shares, blocks=blocks)
