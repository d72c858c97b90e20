"""Power grows with trials, and the number of trials needed lies where it crosses the target."""

import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.simulation.power.flip_rates import default_worlds, needed, power, stated_world
from lockprobe.simulation.power.rates import Rate

P2 = (0.0, 0.4)


def ladder(*rejected, studies=100, trials=(15, 30, 60)):
    made = {"world": "w", "question": "success", "test": "t", "truth": True}
    return [Rate(**made, trials=n, studies=studies, rejected=k) for n, k in zip(trials, rejected, strict=True)]


def test_the_papers_effect_needs_about_nineteen_trials_a_condition():
    """By 600 studies it is 15 to 27; these 48 studies, on coarser rungs, are within 11 to 34."""
    found, _ = power([stated_world((7 / 30, 20 / 30), p=P2)], p=P2, trials=(12, 24, 48), studies=16, seed=1)
    assert found.test == "greatest difference from the lowest dose, permutation"
    assert 11 <= found.trials <= 34
    assert [rate.trials for rate in found.measured] == [12, 24, 48]
    assert found.measured[0].rate < found.measured[2].rate


def test_only_questions_with_a_yes_are_answered():
    flat = power([stated_world((0.5, 0.5), p=P2)], p=P2, trials=(9,), studies=2)
    assert flat == []
    assert {one.question for one in power([default_worlds()[0]], trials=(9,), studies=2)} == {
        "success",
        "speed",
        "shape",
    }


@pytest.mark.parametrize(
    ("rejected", "trials", "below"),
    [((20, 50, 70), None, False), ((85, 90, 99), 15, True), ((20, 80, 99), 30, False), ((20, 60, 100), 43, False)],
)
def test_the_crossing_is_interpolated(rejected, trials, below):
    found = needed(ladder(*rejected), 0.8)
    assert (found.trials, found.below) == (trials, below)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"success": (0.5,)}, "one share for each of 7 flip rates"),
        ({"success": (0.5, 1.0), "p": P2}, "success: got 1.0"),
        ({"success": (0.5, 0.6), "p": (0.4, 0.0)}, "ascending"),
        ({"success": (0.5, 0.6), "p": (0.5, 0.500000001)}, "0.500000001', expected values that differ by 0.000001"),
        ({"success": (0.5, 0.6, 0.5), "p": (0.0, 1e-300, 0.5)}, "differ by 0.000001"),
        ({"success": (0.5, 0.6), "p": P2, "trap": (0.1,)}, "one chance for each of 2 flip rates"),
        ({"success": (0.5, float("nan")), "p": P2}, "success: got nan"),
    ],
)
def test_impossible_effects_are_refused(settings, message):
    with pytest.raises(BadValue, match=message):
        stated_world(**settings)


def test_truths_follow_from_the_effect():
    assert stated_world((0.2, 0.6, 0.4), p=(0.0, 0.3, 0.6)).truths == {"success", "speed", "shape"}
    assert stated_world((0.5, 0.5), p=P2, trap=(0.4, 0.1)).truths == {"looping"}
    assert stated_world((0.5, 0.5), p=P2, trap=(0.0, 0.4)).truths == {"looping"}


def test_impossible_designs_are_refused():
    effect = stated_world((0.2, 0.6), p=P2)
    for settings, message in (
        ({"target": 1.0}, "target power"),
        ({"trials": ()}, "trials per flip rate"),
        ({"trials": (15, 10_001)}, "at most 10000"),
        ({"p": (0.4, 0.4 + 1e-9)}, "differ by 0.000001"),
    ):
        with pytest.raises(BadValue, match=message):
            power([effect], **({"p": P2, "studies": 1} | settings))


def test_the_number_of_trials_has_the_error_of_its_simulation():
    few, many = (needed(ladder(*(k * n // 100 for k in (20, 80, 99)), studies=n), 0.8) for n in (100, 10_000))
    assert few.low < 30 < few.high
    assert few.low < many.low <= many.trials == few.trials == 30 <= many.high < few.high
    open_ended = needed(ladder(20, 50, 82), 0.8)
    assert (open_ended.trials, open_ended.high) == (58, None)
    at_once = needed(ladder(78, 90, 99), 0.8)
    assert (at_once.low, at_once.below) == (None, False)
