"""The ranks that agents may have: decided where agents differ, all of them where they are equal."""

import numpy as np

from lockprobe.statistics.outcomes import Outcomes
from lockprobe.statistics.suite.ranks import possible_ranks


def told(*rates, n=36, rng=None, first=1):
    """The trials of one agent, level by level; without a stream the first ones are solved."""
    levels = []
    for rate in rates:
        solved = np.arange(n) < rate * n if rng is None else rng.random(n) < rate
        ones = np.ones(n, dtype=np.int64)
        trial = np.arange(first, first + n)
        levels.append(
            Outcomes(dose=0.0 * ones, repetition=ones, trial=trial, length=ones, solved=solved, onset=0 * ones)
        )
    return levels


def test_agents_that_differ_clearly_are_ranked_and_a_tie_is_not():
    assert possible_ranks([told(0.2, 0.1), told(0.9, 0.9), told(0.9, 0.9)]) == [(3, 3), (1, 2), (1, 2)]
    assert possible_ranks([told(0.5), told(0.5)]) == [(1, 2), (1, 2)]
    assert possible_ranks([told(0.5)]) == [(1, 1)]
    assert possible_ranks([]) == []


def test_agents_without_a_trial_in_common_are_not_ranked_by_it():
    assert possible_ranks([told(0.0), told(1.0, first=100)]) == [(1, 2), (1, 2)]


def test_of_many_equal_agents_none_is_called_better():
    """Eight agents that are equally good: no order is shown in at least 95 % of 40 suites, within error."""
    rng = np.random.default_rng(1)
    wrong = sum(
        any(ranks != (1, 8) for ranks in possible_ranks([told(0.8, 0.6, 0.5, 0.3, rng=rng) for _ in range(8)]))
        for _ in range(40)
    )
    assert wrong <= 5


def test_the_true_rank_is_possible_where_agents_differ():
    rng = np.random.default_rng(2)
    found = possible_ranks([told(*(np.array((0.8, 0.6, 0.5, 0.3)) - 0.05 * i), rng=rng) for i in range(6)])
    assert all(low <= i <= high for i, (low, high) in enumerate(found, 1))
    assert found[0][1] < 6
