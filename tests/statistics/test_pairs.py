"""Few differing pairs: the score statistic by brute force, coverage by exact enumeration."""

from itertools import product

import numpy as np
import pytest
from scipy.special import gammaln, xlogy
from scipy.stats import norm

from lockprobe.statistics.pairs import FEW, paired, score, score_interval


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
            found = paired(*made(*table, pairs))
            assert (found.interval_p < 0.05) == (found.low > 0 or found.high < 0), (table, pairs)
