"""Stated effects are simulated, and the tests of the report detect them as often as they should."""

import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.simulation.power.effects import (
    STATED,
    Boxes,
    default_worlds,
    due,
    flip_power,
    power_over_boxes,
    right,
    stated_world,
    why_power,
    wrong,
)
from lockprobe.simulation.power.simulator import Simulation
from lockprobe.statistics.why.mechanism import MARGIN

P2 = (0.0, 0.4)


def test_the_papers_effect_needs_about_nineteen_trials_a_condition():
    """By 600 studies it is 15 to 27; these 48 studies, on coarser rungs, are within 11 to 34."""
    (_, question, found), _ = flip_power(
        [stated_world((7 / 30, 20 / 30), p=P2)], Simulation(trials=(12, 24, 48), studies=16)
    )
    assert question == "success"
    assert 11 <= found.trials <= 34
    assert [rate.trials for rate in found.measured] == [12, 24, 48]
    assert found.measured[0].power < found.measured[2].power


@pytest.mark.parametrize(
    ("effect", "questions"),
    [
        ({"success": (0.2, 0.6, 0.4), "p": (0.0, 0.3, 0.6)}, ["success", "speed", "shape"]),
        ({"success": (0.5, 0.5), "p": P2, "trap": (0.4, 0.1)}, ["looping"]),
        ({"success": (0.5, 0.5), "p": P2, "trap": (0.0, 0.4)}, ["looping"]),
        ({"success": (0.5,) * 3, "p": (0.0, 0.3, 0.6), "trap": (0.4, 0.1, 0.4)}, ["looping", "looping again"]),
        ({"success": (0.5, 0.5), "p": P2}, []),
    ],
)
def test_only_questions_with_a_yes_are_answered(effect, questions):
    assert [one for _, one, _ in flip_power([stated_world(**effect)], Simulation(trials=(9,), studies=1))] == questions


def test_by_default_there_are_two_effects():
    found = flip_power(default_worlds(), Simulation(trials=(9,), studies=1))
    assert [(world.name, question) for world, question, _ in found] == [
        *(("loops-irrelevant", one) for one in ("success", "speed", "shape")),
        ("loop-trapped", "looping"),
    ]


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"success": (0.5,)}, "one share for each of 7 flip rates"),
        ({"success": (0.5, 1.0), "p": P2}, "success: got 1.0"),
        ({"success": (0.5, 0.6), "p": (0.4, 0.0)}, "ascending"),
        ({"success": (0.5, 0.6), "p": (0.5, 0.500000001)}, "0.500000001', expected values that differ by 0.000001"),
        ({"success": (0.5, 0.6, 0.5), "p": (0.0, 1e-300, 0.5)}, "differ by 0.000001"),
        ({"success": (0.5, 0.6), "p": P2, "trap": (0.1,)}, "one chance for each of 2 flip rates"),
        ({"success": (0.5, 0.6), "p": P2, "trap": (0.1, 1.1)}, "trap: got 1.1"),
        ({"success": (0.5, float("nan")), "p": P2}, "success: got nan"),
    ],
)
def test_impossible_effects_are_refused(settings, message):
    with pytest.raises(BadValue, match=message):
        stated_world(**settings)


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
