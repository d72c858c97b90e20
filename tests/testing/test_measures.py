"""The contract of measures holds for ours and finds who breaks it."""

from itertools import count

import pytest

from lockprobe.foundation.errors import BadValue, UserMistake
from lockprobe.statistics.measures import MEASURES
from lockprobe.testing import check_measure


@pytest.mark.parametrize("name", MEASURES)
def test_measures_that_keep_it(name):
    check_measure(name)


NUMBERS = count()


def grows(trial):
    """Another number whenever it is asked."""
    return next(NUMBERS)


def writes(trial):
    """Leaves something in the trial."""
    trial.facts["seen"] = True
    return 1.0


def silent(trial):
    """Applies to nothing."""


def both(trial):
    """Yes or no where it was solved, else a number."""
    return True if trial.solved else 0.5


@pytest.mark.parametrize(
    ("measure", "said"),
    [
        (grows, "another number when it is asked for again"),
        (writes, "changes the trial"),
        (silent, "applies to no trial"),
        (both, "a number of one trial, and yes or no of another"),
    ],
)
def test_measures_that_break_it(measure, said):
    with pytest.raises(AssertionError, match=said):
        check_measure(measure)


def test_a_measure_that_breaks_on_trials_without_steps_is_found():
    with pytest.raises(ZeroDivisionError):
        check_measure(lambda trial: 1 / len(trial.steps))
    with pytest.raises(BadValue, match="expected a finite number"):
        check_measure(lambda trial: "many")
    with pytest.raises(UserMistake, match="no measure is called"):
        check_measure("many")
