"""The number of trials needed lies where power crosses the target, with the error of its simulation."""

from collections import Counter

import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.simulation.power.simulator import Simulation, needed


def ladder(*detected, studies=100, trials=(15, 30, 60)):
    """What is needed, if it was detected in so many studies at each of the numbers of trials."""
    found = {size: Counter(it=k) for size, k in zip(trials, detected, strict=True)}
    return needed(found, "it", Simulation(studies=studies))


@pytest.mark.parametrize(
    ("detected", "trials", "below"),
    [((20, 50, 70), None, False), ((85, 90, 99), 15, True), ((20, 80, 99), 30, False), ((20, 60, 100), 43, False)],
)
def test_the_crossing_is_interpolated(detected, trials, below):
    found = ladder(*detected)
    assert (found.trials, found.below) == (trials, below)


def test_the_number_of_trials_has_the_error_of_its_simulation():
    few, many = (ladder(*(k * n // 100 for k in (20, 80, 99)), studies=n) for n in (100, 10_000))
    assert few.low < 30 < few.high
    assert few.low < many.low <= many.trials == few.trials == 30 <= many.high < few.high
    open_ended = ladder(20, 50, 82)
    assert (open_ended.trials, open_ended.high) == (58, None)
    at_once = ladder(78, 90, 99)
    assert (at_once.low, at_once.below) == (None, False)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"target": 1.0}, "target power"), ({"target": 0.0}, "target power"), ({"trials": ()}, "trials per condition"),
        ({"trials": (1,)}, "at least 2"),
        ({"trials": (0,), "least": 1}, "at least 1"), ({"trials": (15, 10_001)}, "at most 10000"),
    ],
)  # fmt: skip
def test_impossible_sizes_are_refused(settings, message):
    with pytest.raises(BadValue, match=message):
        Simulation(**settings)
