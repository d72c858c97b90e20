"""Stated effects are simulated, and the tests of the report detect them as often as they should."""

import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.simulation.power.effects import (
    STATED,
    Boxes,
    FlipRates,
    due,
    flip_power,
    power_over_boxes,
    why_power,
    wrong,
)
from lockprobe.simulation.power.simulator import Simulation
from lockprobe.statistics.why import MARGIN

P2 = (0.0, 0.4)


def test_the_papers_effect_needs_about_nineteen_trials_a_condition():
    """By 600 studies it is 15 to 27; these 48 studies, on coarser rungs, are within 11 to 34."""
    ((question, found),) = flip_power(
        FlipRates(success=(7 / 30, 20 / 30), p=P2), Simulation(trials=(12, 24, 48), studies=16)
    )
    assert question == "success"
    assert 11 <= found.trials <= 34
    assert [rate.trials for rate in found.measured] == [12, 24, 48]
    assert found.measured[0].power < found.measured[2].power


@pytest.mark.parametrize(
    ("success", "questions"),
    [((0.2, 0.6, 0.4), ["success", "shape"]), ((0.2, 0.4, 0.6), ["success"]), ((0.5, 0.5, 0.5), [])],
)
def test_only_questions_with_a_yes_are_answered(success, questions):
    rates = FlipRates(success=success, p=(0.0, 0.3, 0.6))
    assert [one for one, _ in flip_power(rates, Simulation(trials=(9,), studies=1))] == questions


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"success": (0.5,)}, "one share from 0 to 1 for each of 7 flip rates"),
        ({"success": (0.5, 1.5), "p": P2}, "success: got '0.5,1.5'"),
        ({"success": (0.5, 0.6), "p": (0.4, 0.0)}, "ascending"),
        ({"success": (0.5, 0.6), "p": (0.5, 0.500000001)}, "differ by 0.000001"),
        ({"success": (0.5, float("nan")), "p": P2}, "success: got '0.5,nan'"),
    ],
)
def test_impossible_effects_are_refused(settings, message):
    with pytest.raises(BadValue, match=message):
        FlipRates(**settings)


@pytest.mark.parametrize(
    ("truth", "total", "are_wrong"),
    [
        ("says", 0.3, {"form", "both", "no change"}),
        ("says", -0.05, {"form", "both"}),
        ("both", 0.3, {"no change"}),
        ("not decided", MARGIN, {"says", "form", "both", "no change"}),
        ("no change", 0, {"says", "form", "both", "blurred", "not decided"}),
    ],
)
def test_what_is_wrong(truth, total, are_wrong):
    verdicts = ("says", "form", "both", "blurred", "not decided", "no change", "inconclusive")
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
    rates = iter(why_power(STATED, Simulation(trials=[20, 400], studies=60)))
    for small, large in zip(rates, rates, strict=True):
        assert max(small.wrong, large.wrong) <= 0.05 + 3 * (0.05 * 0.95 / 60) ** 0.5
        assert small.change == STATED[small.effect][1] - STATED[small.effect][0]
        if small.truth != "no change":
            assert large.right > 0.85
            assert large.claims


@pytest.mark.parametrize("shares", [(0.2, 0.5), (0.2,) * 6 + (1.5,)])
def test_effects_that_are_none_are_refused(shares):
    with pytest.raises(BadValue, match="7 shares from 0 to 1"):
        why_power({"x": shares}, Simulation())


def test_over_boxes_power_grows_with_boxes_and_without_an_effect_keeps_its_level():
    """Of boxes of one difficulty only: where success lies at its bounds, the mean change is not the stated one."""
    how = Simulation(trials=(2, 10), least=1, studies=150)
    few, many, none = (
        power_over_boxes([Boxes(success=success, boxes=boxes, effect_sd=0.05)], how)
        for success, boxes in (((0.4, 0.6), 5), ((0.4, 0.6), 20), ((0.5, 0.5), 10))
    )
    assert few[5, 2] < few[5, 10] < many[20, 10]
    assert few[5, 2] < many[20, 2]
    assert max(none.values()) <= 0.05 + 3 * (0.05 * 0.95 / 150) ** 0.5


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"success": (0.2,)}, "two shares"), ({"success": (0.2, 1.1)}, "two shares"), ({"boxes": 4}, "at least 5"),
        ({"effect_sd": float("nan")}, "effect-sd"), ({"effect_sd": -1.0}, "effect-sd"),
    ],
)  # fmt: skip
def test_what_makes_no_boxes_is_refused(given, said):
    with pytest.raises(BadValue, match=said):
        Boxes(**{"success": (0.2, 0.6), "boxes": 5} | given)
