"""One agent under one condition, and two of its conditions held against each other."""

import numpy as np
import pytest
from builders import SOLUTION, make_trial

from lockprobe.statistics.conditions.condition import condition_summary, contrast
from lockprobe.statistics.inference.difference import any_difference
from lockprobe.statistics.outcomes import outcomes

FAILED = (0,) * 20


def trials_at(p, solved):
    """A trial for every entry, solved or not."""
    return [make_trial(SOLUTION if yes else FAILED, p=p, trial=i) for i, yes in enumerate(solved, 1)]


def held(*groups):
    """The contrast of some conditions, lowest p first."""
    counted = outcomes([trial for group in groups for trial in group])
    tested = any_difference(counted, np.random.default_rng(1))
    return contrast([condition_summary(group) for group in groups], tested)


def test_trials_that_broke_are_counted_apart_and_widen_the_interval_of_success():
    broken = [make_trial([0], trial=9, broken=boundary) for boundary in ("plant", "model", "plant")]
    found = condition_summary([*trials_at(0.0, [True, False, True]), *broken])
    assert (found.success.count, found.success.n, found.success.broken) == (2, 3, 3)
    assert found.success.bounds == (2 / 6, 5 / 6)
    assert found.errors == {"model": 1, "plant": 2}


def test_the_condition_farthest_from_the_lowest_p_is_chosen_in_either_direction():
    solved = {0.0: 8, 0.2: 10, 0.4: 1}
    found = held(*(trials_at(p, [i < count for i in range(12)]) for p, count in solved.items()))
    assert (found.baseline.dose, found.other.dose, found.choices) == (0.0, 0.4, 2)
    assert (found.difference.value, found.difference.pairs.value) == pytest.approx((-7 / 12, -7 / 12))
    assert found.farthest
    assert found.whole


def test_pairs_are_trials_of_equal_number():
    found = held(trials_at(0.0, [True, False, False, True, False]), trials_at(0.4, [True, True, True, False]))
    assert ((pairs := found.difference.pairs).n, pairs.only_first, pairs.only_second) == (4, 1, 2)
    assert (found.difference.first.n, found.difference.second.n, found.whole) == (4, 4, False)


def test_nothing_to_hold_against_each_other():
    assert held(trials_at(0.0, [True])) is None
    broken = [make_trial([0], p=0.4, broken="model")]
    assert held(trials_at(0.0, [True, False]), broken) is None
