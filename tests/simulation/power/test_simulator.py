"""The number of trials needed lies where power crosses the target, with the error of its simulation."""

import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.simulation.power.simulator import Rate, Simulation, needed


def ladder(*detected, studies=100, trials=(15, 30, 60)):
    return [Rate(trials=n, studies=studies, detected=k) for n, k in zip(trials, detected, strict=True)]


@pytest.mark.parametrize(
    ("detected", "trials", "below"),
    [((20, 50, 70), None, False), ((85, 90, 99), 15, True), ((20, 80, 99), 30, False), ((20, 60, 100), 43, False)],
)
def test_the_crossing_is_interpolated(detected, trials, below):
    found = needed(ladder(*detected), 0.8)
    assert (found.trials, found.below) == (trials, below)


def test_the_number_of_trials_has_the_error_of_its_simulation():
    few, many = (needed(ladder(*(k * n // 100 for k in (20, 80, 99)), studies=n), 0.8) for n in (100, 10_000))
    assert few.low < 30 < few.high
    assert few.low < many.low <= many.trials == few.trials == 30 <= many.high < few.high
    open_ended = needed(ladder(20, 50, 82), 0.8)
    assert (open_ended.trials, open_ended.high) == (58, None)
    at_once = needed(ladder(78, 90, 99), 0.8)
    assert (at_once.low, at_once.below) == (None, False)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"target": 1.0}, "target power"), ({"target": 0.0}, "target power"), ({"trials": ()}, "trials per condition"),
        ({"trials": (1,)}, "at least 2"), ({"trials": (15, 10_001)}, "at most 10000"),
    ],
)  # fmt: skip
def test_impossible_sizes_are_refused(settings, message):
    with pytest.raises(BadValue, match=message):
        Simulation(**settings)
