"""Shares of trials that come in clusters of two kinds at once: of one person, and of equal luck."""

import numpy as np
import pytest

from lockprobe.analysis.clustered import clustered_proportion, crossed_proportion, crossed_spread


def test_clusters_of_one_kind_alone_give_what_that_kind_gives():
    rng = np.random.default_rng(1)
    person = np.repeat(np.arange(12), 5)
    solved = rng.random(60) < np.where(person < 6, 0.2, 0.8)
    found = crossed_proportion(solved, np.ones(60), person, np.arange(60))
    alone = clustered_proportion(np.bincount(person, weights=solved), np.full(12, 5))
    assert (found.low, found.high) == pytest.approx((alone.low, alone.high))
    assert (found.count, found.n, found.clusters) == (alone.count, 60, 12)


def test_two_kinds_add_up_less_what_both_hold():
    residuals = np.array([1.0, 1.0, -1.0, -1.0])
    assert crossed_spread(residuals, [0, 0, 1, 1], [0, 1, 2, 3]) == pytest.approx(2 / 1 * 8)
    first, second, trial = 2 / 1 * 8, 2 / 1 * 0, 4 / 3 * 4
    assert crossed_spread(residuals, [0, 0, 1, 1], [0, 1, 0, 1]) == pytest.approx(max(first, first + second - trial))


def test_it_is_never_narrower_than_with_either_kind():
    rng = np.random.default_rng(2)
    for _ in range(50):
        solved, person, luck = rng.random(40) < 0.4, rng.integers(0, 8, 40), rng.integers(0, 10, 40)
        both = crossed_proportion(solved, np.ones(40), person, luck)
        for kind in (person, luck):
            one = clustered_proportion(np.bincount(kind, weights=solved), np.bincount(kind))
            assert both.high - both.low >= one.high - one.low - 1e-9


def test_order_does_not_matter_and_trials_without_claims_do_not_count():
    counts, sizes = [1, 0, 2, 0], [2, 1, 2, 0]
    found = crossed_proportion(counts, sizes, ["a", "a", "b", "c"], [1, 2, 1, 3])
    assert (found.count, found.n, found.clusters) == (3, 5, 2)
    assert found == crossed_proportion(counts[::-1], sizes[::-1], ["c", "b", "a", "a"], [3, 1, 2, 1])


def test_one_person_says_nothing_about_people():
    found = crossed_proportion([1, 0, 1], [1, 1, 1], ["a"] * 3, [1, 2, 3])
    assert (found.value, found.low, found.high) == (2 / 3, 0.0, 1.0)


def test_the_interval_holds_the_truth_where_that_of_one_kind_fails():
    """Everybody meets every luck's twin at another p; people differ. The truth is held in 95 of 100, or nearly."""
    rng, held, by_luck = np.random.default_rng(5), 0, 0
    luck = np.repeat(np.arange(30), 7)
    person = (luck - np.tile(np.arange(7), 30)) % 30
    for _ in range(200):
        able = 0.8 * rng.standard_normal(30)[person]
        solved = able + 0.6 * rng.standard_normal(210) > 0
        both = crossed_proportion(solved, np.ones(210), person, luck)
        one = clustered_proportion(np.bincount(luck, weights=solved), np.full(30, 7))
        held += both.low <= 0.5 <= both.high
        by_luck += one.low <= 0.5 <= one.high
    assert held >= 180
    assert by_luck < 170
