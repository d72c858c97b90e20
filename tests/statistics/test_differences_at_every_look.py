"""Differences in success at every look, in the order of the plan and whatever the order of arrival."""

from dataclasses import replace

import numpy as np
import pytest
from solved import drawn, people, rng, study

from lockprobe.statistics.differences import any_difference, each_difference
from lockprobe.statistics.outcomes import BlockOrder

ORDER = BlockOrder(plans=((3, 20),))
P = [0.0, 0.2, 0.4]


def watched(success=(0.2, 0.25, 0.7), order=ORDER, seed=1, shape=(3, 3, 20)):
    solved = drawn(rng(seed), success, shape, shared=0.3)
    return replace(study(solved, P), order=order), solved.reshape(3, -1)


def by_dose(found):
    return [found.at(found.dose == p) for p in np.unique(found.dose)]


def test_no_decision_depends_on_the_order_of_arrival():
    found, _ = watched()
    expected = any_difference(found, rng())
    for seed in range(2):
        arrived = rng(seed).permutation(len(found))
        mixed = found.at(arrived)
        for one, other in zip(any_difference(mixed, rng()), expected, strict=True):
            assert (one.p_value, one.low, one.high) == (other.p_value, other.low, other.high)
            assert one.course.effect_at == other.course.effect_at


def test_only_blocks_that_both_have_are_compared_and_keep_their_places():
    found, solved = watched()
    missing = (found.dose == 0.4) & (found.trial % 3 == 0)
    first, *others = by_dose(found.at(~missing))
    _, (_, change) = each_difference([first, *others])
    there = np.array([(i % 20 + 1) % 3 != 0 for i in range(60)])
    assert change.second.n == there.sum()
    assert change.value == pytest.approx((solved[2].astype(float) - solved[0])[there].mean())
    assert set(change.course.blocks - 1) <= set(np.flatnonzero(there))


def test_people_come_as_they_please_and_are_compared_at_one_look():
    found = people(rng(), 6, 5, 0.5)
    ordered = replace(found, order=BlockOrder(plans=((1, 30),)))
    assert any_difference(ordered, rng()) == any_difference(found, rng())
