"""Differences of paired proportions where few pairs differ: a score interval, and an exact test of equivalence.

If 18 pairs of 18 agree, the usual intervals are too narrow, because they estimate a variance from pairs that do not
differ: a change of 10 points leaves all 18 alike in 15 % of studies. The score statistic (Tango, Statistics in Medicine
1998) uses the variance under the difference that is tested, so it has a width even there.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lockprobe.statistics.distributions import normal_quantile

FEW = 5
"""The most differing pairs with which McNemar's exact test cannot reject at 5 %."""

MOST_EXACT = 200
"""Pairs up to which the test of equivalence is exact; beyond, its statistic is approximately normal, and at a margin of
10 points it is wrong in at most 5.4 % of studies."""

_SHARES = 60
"""Shares of pairs that differ for which the exact test is computed; it takes the largest P value."""

_TIE = 1e-9

Array = NDArray[np.float64]


def score(only_first: ArrayLike, only_second: ArrayLike, pairs: int, change: float) -> Array:
    """Tango's score statistic of a difference, standard normal if it is ``change``; negative below it.

    Args:
        only_first: Pairs solved under the first condition alone.
        only_second: Pairs solved under the second condition alone.
        pairs: All pairs.
        change: The hypothetical share under the second condition minus that under the first, (-1, 1).
    """
    first, second = np.asarray(only_first, dtype=np.float64), np.asarray(only_second, dtype=np.float64)
    linear = (2 * pairs + first - second) * change - first - second
    constant = -first * change * (1 - change)
    share = (np.sqrt(np.maximum(linear**2 - 8 * pairs * constant, 0.0)) - linear) / (4 * pairs)
    variance = pairs * (2 * share + change * (1 - change))
    away = second - first - pairs * change
    return np.where(variance > 0, away / np.sqrt(np.maximum(variance, 1e-300)), 0.0)


def score_interval(only_first: int, only_second: int, pairs: int, level: float) -> tuple[float, float]:
    """Tango's interval of a paired difference, for at least one pair; level in (0, 1).

    >>> [round(end, 3) for end in score_interval(0, 0, 18, 0.95)]
    [-0.176, 0.176]
    """
    from scipy.optimize import brentq

    z, value, end = -normal_quantile((1 - level) / 2), (only_second - only_first) / pairs, 1 - 1e-9

    def above(change: float, by: float) -> float:
        return float(score(only_first, only_second, pairs, change)) - by

    low = brentq(above, -end, value, args=(z,)) if value > -end and above(-end, z) > 0 else -1.0
    high = brentq(above, value, end, args=(-z,)) if value < end and above(end, -z) < 0 else 1.0
    return float(low), float(high)


def equivalence(only_first: int, only_second: int, pairs: int, margin: float) -> float:
    """P value of two one-sided tests that the difference is the margin or more in either direction.

    Up to :data:`MOST_EXACT` pairs each test is exact and unconditional: the largest probability, over all shares of
    pairs that differ, of a score as far from the margin (Liu, Hsueh, Hsieh and Chen, Statistics in Medicine 2002).

    >>> round(equivalence(0, 0, 18, 0.1), 3), round(equivalence(0, 0, 29, 0.1), 3)
    (0.15, 0.049)
    """
    return max(_at_most(only_first, only_second, pairs, margin), _at_most(only_second, only_first, pairs, margin))


@lru_cache(maxsize=4096)
def _at_most(only_first: int, only_second: int, pairs: int, margin: float) -> float:
    """P value of the test that the difference is the margin or more, against less."""
    from scipy.special import gammaln, ndtr, xlogy

    found = float(score(only_first, only_second, pairs, margin))
    if pairs > MOST_EXACT:
        return float(ndtr(found))
    first, second = _tables(pairs)
    as_far = score(first, second, pairs, margin) <= found + _TIE
    first, second = first[as_far], second[as_far]
    alike = pairs - first - second
    ways = math.lgamma(pairs + 1) - gammaln(first + 1) - gammaln(second + 1) - gammaln(alike + 1)
    return max(
        float(np.exp(ways + xlogy(first, share) + xlogy(second, share + margin) + xlogy(alike, rest)).sum())
        for share in (1 - margin) / 2 * np.linspace(0, 1, _SHARES) ** 2
        for rest in [max(0.0, 1 - margin - 2 * share)]
    )


@lru_cache(maxsize=8)
def _tables(pairs: int) -> tuple[Array, Array]:
    """All possible counts of pairs solved under one condition alone, one entry for each table."""
    first, second = np.indices((pairs + 1, pairs + 1)).reshape(2, -1).astype(np.float64)
    possible = first + second <= pairs
    return first[possible], second[possible]
