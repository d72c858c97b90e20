"""Shares of trials that come in clusters of two kinds at once: of one person, and of equal luck."""

import numpy as np
import pytest
from scipy.stats import norm
from solved import people

from lockprobe.statistics.clustered import (
    clustered_difference,
    clustered_proportion,
    crossed_proportion,
    share_of,
    two_way_variance,
)
from lockprobe.statistics.proportions import proportion


def test_two_kinds_add_up_less_what_both_hold():
    residuals = np.array([1.0, 1.0, -1.0, -1.0])
    assert two_way_variance(residuals, [0, 0, 1, 1], [0, 1, 2, 3]) == pytest.approx(2 / 1 * 8)
    first, second, trial = 2 / 1 * 8, 2 / 1 * 0, 4 / 3 * 4
    assert two_way_variance(residuals, [0, 0, 1, 1], [0, 1, 0, 1]) == pytest.approx(max(first, first + second - trial))


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


def ends(counts, sizes):
    found = clustered_proportion(counts, sizes)
    return found.low, found.high


@pytest.mark.parametrize("copies", [1, 4, 7])
@pytest.mark.parametrize("success", [True, False])
def test_where_all_or_none_succeed_a_cluster_counts_as_one_trial(copies, success):
    sizes = np.full(30, copies)
    assert ends(sizes * success, sizes) == pytest.approx(ends(np.full(30, success), np.ones(30)))
    both = crossed_proportion(np.full(30 * copies, success), np.ones(30 * copies), np.arange(30 * copies) // copies,
                              np.arange(30 * copies))  # fmt: skip
    assert (both.low, both.high) == pytest.approx(ends(sizes * success, sizes))


def test_the_half_cluster_is_forgotten_as_failures_show_how_they_come():
    """One failure in each of f clusters of four: the more there are, the nearer to independent trials."""
    effects = [clustered_proportion([3] * f + [4] * (100 - f), [4] * 100).design_effect for f in (0, 1, 5, 20, 60)]
    assert effects == sorted(effects, reverse=True)
    assert effects[0] == pytest.approx(4)
    assert effects[-1] < 1.05
    wholly = clustered_proportion([0] * 50 + [4] * 50, [4] * 100)
    assert wholly.design_effect == pytest.approx(4 * 100 / 99)


@pytest.mark.parametrize("alike", ["identical", "half", "independent"])
@pytest.mark.parametrize("truth", [0.9, 0.98])
def test_intervals_near_the_ceiling_hold_the_truth(alike, truth):
    rng, held = np.random.default_rng(8), 0
    for _ in range(400):
        same, own = np.repeat(rng.random((30, 1)) < truth, 7, axis=1), rng.random((30, 7)) < truth
        copied = {"identical": 1.0, "half": 0.5, "independent": 0.0}[alike]
        low, high = ends(np.where(rng.random((30, 1)) < copied, same, own).sum(axis=1), np.full(30, 7))
        held += low <= truth <= high
    assert held >= 0.91 * 400


def test_a_share_of_one_condition_is_wilsons_for_agents_and_knows_people():
    solved = np.repeat([True, True, False, False], 5)
    luck, person = np.arange(20), np.repeat(list("abcd"), 5)
    assert share_of(solved, np.empty(0, dtype=np.str_), luck) == proportion(10, 20)
    found, crossed = share_of(solved, person, luck), crossed_proportion(solved, np.ones(20), person, luck)
    assert (found.count, found.n, found.low, found.high) == (10, 20, crossed.low, crossed.high)
    assert found.low < proportion(10, 20).low


@pytest.mark.parametrize(("per_p", "boxes", "likeness"), [(10, 3, 0.35), (6, 5, 0.5), (6, 10, 0.5)])
def test_the_interval_of_people_at_a_single_p_holds_the_truth(per_p, boxes, likeness):
    """As independent trials it holds it in as few as six of ten studies."""
    together, alone = [], []
    for seed in range(200):
        columns = people(np.random.default_rng(seed), per_p, boxes, likeness, p=1)
        for kept, names in ((together, columns.player), (alone, [])):
            found = share_of(columns.solved, names, columns.luck)
            kept.append(found.low <= 0.5 <= found.high)
    assert np.mean(together) >= 0.95 - 2.5 * np.sqrt(0.05 * 0.95 / 200)
    assert np.mean(alone) < np.mean(together)


def left_after_failures(rng, people=60, boxes=6, leaves=0.5, likeness=0.5):
    """Who played each trial, and whether it was solved; people are unequally able, and some leave after a failure."""
    able = rng.standard_normal(people)
    chance = norm.cdf(likeness**0.5 * able / (1 - likeness) ** 0.5)
    played = []
    for i in range(people):
        for _ in range(boxes):
            played.append((i, bool(rng.random() < chance[i])))
            if not played[-1][1] and rng.random() < leaves:
                break
    return np.array(played).T


@pytest.mark.parametrize(("people", "boxes", "leaves"), [(60, 6, 0.5), (30, 4, 1.0), (40, 8, 0.5), (30, 4, 0.0)])
def test_the_interval_holds_the_truth_though_those_who_fail_leave(people, boxes, leaves):
    """By box alone it holds one half in 53 to 97 % of studies, with every person counted alike in 62 to 97 %."""
    held = []
    for seed in range(150):
        who, solved = left_after_failures(np.random.default_rng([seed, people]), people, boxes, leaves)
        found = crossed_proportion(solved, np.ones(len(who)), who, np.arange(len(who)))
        held.append(found.low <= 0.5 <= found.high)
    assert np.mean(held) >= 0.95 - 2.5 * np.sqrt(0.05 * 0.95 / 150)


def test_a_difference_of_people_must_hold_both_ways():
    """One person with many trials makes all of the pooled difference."""
    who = np.concatenate([np.arange(10), 10 + np.arange(10), np.full(60, 19)])
    later = np.arange(80) >= 10
    happened = np.concatenate([np.arange(10) % 2, np.arange(10) % 2, np.ones(60)])
    found = clustered_difference(happened, later, who, np.arange(80))
    assert found.value > 0.3
    assert found.low < 0 < found.high
    assert found.interval_p > 0.05
