"""The test of differences from the lowest p: against all permutations, its level, its interval, and at every look."""

import itertools
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binomtest
from solved import TRUTH, drawn, people, rng, smallest, study, unequal_luck

from lockprobe.statistics.clustered import share_of
from lockprobe.statistics.differences import any_difference, each_difference
from lockprobe.statistics.distributions import sign_test
from lockprobe.statistics.outcomes import BlockOrder
from lockprobe.statistics.pairs import paired


@contextmanager
def without_the_interval():
    """As long as it lasts, the P value of a difference is that of the permutation, or McNemar's, alone."""

    def alone(first, second, box, *, choices, exchange):
        found = paired(first, second, box, choices=choices)
        tested = choices * sign_test(int((first & ~second).sum()), int((second & ~first).sum()))
        return replace(found, p_value=min(1.0, tested) if exchange is None else exchange)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("lockprobe.statistics.differences.paired", alone)
        yield


def everything(solved):
    """Exact p-values over all permutations inside clusters: each difference in standard errors."""
    table = np.asarray(solved, dtype=float).reshape(len(solved), -1).T
    each = [set(itertools.permutations(row)) for row in table]
    weights = [[1 / len(options)] * len(options) for options in each]
    found = []
    for rows, chances in zip(itertools.product(*each), itertools.product(*weights), strict=True):
        success = np.mean(rows, axis=0)
        away = np.abs(success[1:] - success[0])
        found.append((np.prod(chances), *away))
    chance, *away = np.array(found).T
    error = np.sqrt(np.array(away) ** 2 @ chance + 1 / len(table) ** 2)
    largest = (np.array(away) / error[:, None]).max(axis=0)
    seen = table.mean(axis=0)
    return [chance[largest >= value - 1e-9].sum() for value in np.abs(seen[1:] - seen[0]) / error]


@pytest.mark.parametrize("seed", range(4))
def test_the_permutation_test_is_what_all_permutations_give(seed):
    solved = drawn(rng(seed), success=np.array([0.2, 0.5, 0.8]), shape=(3, 1, 6))
    found = any_difference(study(solved), rng(9), permutations=20000)
    with without_the_interval():
        alone = any_difference(study(solved), rng(9), permutations=20000)
    assert [one.p_value for one in alone] == pytest.approx(everything(solved), abs=0.015)
    assert all(both.p_value >= one.p_value for both, one in zip(found, alone, strict=True))


def test_p_that_changes_which_trials_are_solved_and_not_how_many_is_no_finding():
    """The permutation alone rejects in a seventh of such studies; with the interval hardly ever."""
    found = [any_difference(study(unequal_luck(rng(seed))), rng(seed), permutations=99) for seed in range(60)]
    with without_the_interval():
        alone = [any_difference(study(unequal_luck(rng(seed))), rng(seed), permutations=99) for seed in range(60)]
    assert np.mean([smallest(one) < 0.05 for one in alone]) > 0.06
    assert np.mean([smallest(one) < 0.05 for one in found]) < 0.05


def test_an_estimate_and_its_interval_are_of_the_trials_that_both_have():
    """Thirty trials at the lowest p and five at the other: seven of those thirty have nothing to do with the five."""
    none = study(drawn(rng(), TRUTH[:3], shape=(3, 1, 20)))
    assert [at.dose for at in any_difference(none.at((none.dose != 0.1) | (none.trial > 20)), rng())] == [0.2]
    whole = study(np.stack([np.r_[np.zeros(22), np.ones(8)], np.ones(30)])[:, None])
    some = whole.at((whole.dose == 0) | (whole.trial <= 5))
    (at,) = any_difference(some, rng())
    assert (at.first.count, at.first.n, at.second.count, at.second.n) == (0, 5, 5, 5)
    both = paired(np.zeros(5, dtype=bool), np.ones(5, dtype=bool))
    assert (at.value, at.low, at.high) == (both.value, both.low, both.high) == (1.0, both.low, 1.0)


@pytest.mark.parametrize(("per_p", "boxes", "likeness"), [(10, 3, 0.35), (6, 10, 0.5)])
def test_intervals_of_differences_between_people_hold_the_truth(per_p, boxes, likeness):
    held = []
    for seed in range(80):
        (at,) = any_difference(people(rng(seed), per_p, boxes, likeness, p=2), rng(seed), permutations=19)
        held.append(at.low <= 0 <= at.high)
    assert np.mean(held) >= 0.95 - 2.5 * np.sqrt(0.05 * 0.95 / 80)


def test_conditions_are_compared_with_the_first_one_alone_and_corrected_for_their_number():
    solved = np.zeros((3, 1, 20))
    solved[1, 0, :9], solved[2, 0, 3:6] = 1, 1
    first, *others = (study(solved[i : i + 1]) for i in range(3))
    found = each_difference([first, *others], agents=2)
    with without_the_interval():
        (alone,) = (one for _, one in each_difference([first, others[0]]))
        both = dict(each_difference([first, *others], agents=2))
    assert alone.p_value == pytest.approx(binomtest(9, 9).pvalue)
    assert [one.p_value for one in both.values()] == pytest.approx([4 * binomtest(9, 9).pvalue, 4 * 0.25])
    assert all(one.p_value >= both[place].p_value for place, one in found)
    assert (both[1].value, both[1].second, both[1].dose) == (alone.value, alone.second, 1.0)
    assert alone.low > both[1].low


ORDER = BlockOrder(plans=((3, 20),))
P = [0.0, 0.2, 0.4]


def watched(success=(0.2, 0.25, 0.7), order=ORDER, seed=1, shape=(3, 3, 20)):
    solved = drawn(rng(seed), success, shape, shared=0.3)
    return replace(study(solved, P), order=order), solved.reshape(3, -1)


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
    first, *others = (found.at(~missing & (found.dose == p)) for p in P)
    _, (_, change) = each_difference([first, *others])
    there = np.array([(i % 20 + 1) % 3 != 0 for i in range(60)])
    assert change.second.n == there.sum()
    assert change.value == pytest.approx((solved[2].astype(float) - solved[0])[there].mean())
    assert set(change.course.blocks - 1) <= set(np.flatnonzero(there))


def test_people_come_as_they_please_and_are_compared_at_one_look():
    found = people(rng(), 6, 5, 0.5)
    ordered = replace(found, order=BlockOrder(plans=((1, 30),)))
    (at, *_) = judged = any_difference(found, rng())
    assert any_difference(ordered, rng()) == judged
    one = found.at(found.dose == found.dose.min())
    assert at.first == share_of(one.solved, one.player, one.luck)  # as every table has it
