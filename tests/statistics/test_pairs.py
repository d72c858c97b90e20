"""Pairs: the score statistic by brute force, coverage by exact enumeration; boxes as clusters in simulated worlds."""

from itertools import product

import numpy as np
import pytest
from scipy.special import gammaln, xlogy
from scipy.stats import norm

from lockprobe.statistics.pairs import FEW, FEWEST, between_boxes, mean_over_boxes, paired, score, score_interval
from lockprobe.statistics.proportions import Difference


def tables(pairs):
    """All counts of pairs solved under one condition alone."""
    return [(one, two) for one in range(pairs + 1) for two in range(pairs + 1 - one)]


def chances(found, pairs, first, second):
    """The probability of each table where such shares of pairs are solved under one condition alone."""
    one, two = np.array(found, dtype=float).reshape(-1, 2).T
    alike = pairs - one - two
    ways = gammaln(pairs + 1) - gammaln(one + 1) - gammaln(two + 1) - gammaln(alike + 1)
    return np.exp(ways + xlogy(one, first) + xlogy(two, second) + xlogy(alike, max(0.0, 1 - first - second)))


def made(only_first, only_second, pairs):
    """The outcomes of so many pairs under both conditions."""
    place = np.arange(pairs)
    return place < only_first, (place >= only_first) & (place < only_first + only_second)


def test_the_interval_ends_where_the_score_is_the_normal_quantile():
    z = norm.isf(0.025)
    low, high = score_interval(2, 5, 30, 0.95)
    assert float(score(2, 5, 30, low)) == pytest.approx(z)
    assert float(score(2, 5, 30, high)) == pytest.approx(-z)
    assert score_interval(0, 0, 18, 0.95)[1] == pytest.approx(z**2 / (18 + z**2))
    assert score_interval(0, 1, 1, 0.95)[1] == score_interval(0, 9, 9, 0.95)[1] == 1.0


@pytest.mark.parametrize("pairs", [10, 18, 30])
def test_intervals_of_pairs_hold_the_truth(pairs):
    """Agresti and Min's alone hold a change of 10 points in .849 of studies of 18 pairs."""
    every = tables(pairs)
    ends = [paired(*made(*table, pairs)) for table in every]
    for change, share in product([0.0, 0.05, 0.1, 0.13, 0.18], [0.0, 0.02, 0.1]):
        held = [one.low <= change <= one.high for one in ends]
        assert chances(every, pairs, share, share + change)[held].sum() > 0.93


def test_few_differing_pairs_have_no_finding_by_the_interval_alone():
    """The P value of the interval is below 0.05 exactly where the interval leaves out 0."""
    for pairs in (6, 18, 40):
        for table in tables(min(pairs, FEW + 3)):
            found = paired(*made(*table, pairs), exchange=0.0)
            assert (found.p_value < 0.05) == (found.low > 0 or found.high < 0), (table, pairs)


def world(rng, k, n, success, effect, sd, tau):
    """A study on k boxes that differ in difficulty and in effect, half of whose trials go alike: its pairs."""
    base = np.clip(success + sd * rng.standard_normal((k, 1)), 0, 1)
    changed = np.clip(base + effect + tau * rng.standard_normal((k, 1)), 0, 1)
    one = rng.random((k, n))
    two = np.where(rng.random((k, n)) < 0.5, one, rng.random((k, n)))
    first, second = one < base, two < changed
    return first.ravel(), second.ravel(), np.repeat(np.arange(k), n)


def boxes(first, second, n):
    """Pairs solved under the first condition alone, and under the second alone, of so many on each box."""
    one, two = [np.arange(n) < many for many in first], [np.arange(n) >= n - many for many in second]
    return np.concatenate(one), np.concatenate(two), np.repeat(np.arange(len(first)), n)


@pytest.mark.parametrize(
    ("k", "n", "success", "effect", "tau"),
    [(5, 5, 0.233, 0.0, 0.0), (10, 5, 0.233, 0.434, 0.15), (20, 20, 0.5, 0.0, 0.3), (10, 20, 0.03, 0.0, 0.0)],
)
def test_the_interval_holds_the_mean_over_boxes(k, n, success, effect, tau):
    """That of trials taken as independent holds it in .94 to .37, from a tau of 0 to .3."""
    rng = np.random.default_rng(3)
    base = np.clip(success + 0.15 * rng.standard_normal(400_000), 0, 1)
    truth = float(np.mean(np.clip(base + effect + tau * rng.standard_normal(400_000), 0, 1) - base))
    found = [paired(*world(rng, k, n, success, effect, 0.15, tau), exchange=0.0) for _ in range(150)]
    assert np.mean([one.low <= truth <= one.high for one in found]) > 0.92
    if not effect:
        assert np.mean([one.p_value < 0.05 for one in found]) < 0.08
    for one in found:
        assert (one.p_value < 0.05) == (one.low > 0 or one.high < 0)


def test_whether_an_effect_differs_is_found_where_it_does_and_seldom_else():
    rng = np.random.default_rng(4)
    alike, apart = (
        [between_boxes(*world(rng, 10, 20, 0.4, 0.2, 0.15, tau))[0].p_value < 0.05 for _ in range(150)]
        for tau in (0.0, 0.3)
    )
    assert np.mean(alike) < 0.08
    assert np.mean(apart) > 0.9
    same, deviation = between_boxes(*boxes([1] * 4, [5] * 4, 10))
    assert (same.p_value, deviation) == (1.0, 0.0)
    assert (same.low, same.high) == pytest.approx((0.4, 0.4))


def test_with_too_few_boxes_or_pairs_nothing_is_said_of_others():
    assert between_boxes(*boxes([0] * 2, [4] * 2, 10)) is None
    assert between_boxes(*boxes([0] * 3, [1] * 3, 4)) is None
    these, others = (paired(*boxes([0] * k, [0, 10, 10, 0, 5][:k], 10)) for k in (4, FEWEST))
    assert these.value == others.value == 0.5
    assert others.low < 0 < these.low  # of four boxes it is known of these, of five it is said of others


def test_means_hold_over_boxes_too():
    box = np.repeat([f"b{i}" for i in range(6)], 10)
    values = np.repeat([1.0, 1, 1, 0, 0, 0], 10)
    found = Difference(value=0.5, low=0.4, high=0.6, p_value=1e-6, n=60, clusters=60)
    over = mean_over_boxes(found, values, box)
    assert over.low < 0.1
    assert over.high > 0.9
    assert over.p_value > 0.05
    assert mean_over_boxes(found, values[:40], box[:40]) == found  # four boxes
