"""Differences of paired proportions: on one box and over several, and an exact test of equivalence.

Pairs are trials of equal luck under two conditions (McNemar's design). The interval is Agresti and Min's (2005). If 18
pairs of 18 agree it is too narrow, because it estimates a variance from pairs that do not differ: a change of 10 points
leaves all 18 alike in 15 % of studies. The score statistic (Tango, Statistics in Medicine 1998) uses the variance under
the difference that is tested, so it has a width even there; where five pairs or fewer differ its interval is held too.

Of several boxes each counts alike. Boxes differ in difficulty and in effect, so an interval that takes their trials as
independent holds the mean over boxes in as little as .36 of studies, and random-effects methods, whose weights depend
on a box's own outcome, in .04 to .10 near 0 and 1. The one here holds it in .94 or more with 3 to 50 boxes of 5 to 60
trials each: Student's over the differences of boxes, *joined* with that of these boxes (the lower of both lows, the
higher of both highs) and, where few boxes differ at all, with Tango's over boxes. It needs luck that differs between
boxes: with equal luck in all of them it would hold .13 to .94.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from statistics import NormalDist

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lockprobe.statistics.distributions import normal_quantile, root, sign_test, student_mean
from lockprobe.statistics.proportions import LEVEL, Difference

FEW = 5
"""The most differing pairs with which McNemar's exact test cannot reject at 5 %."""

FEWEST = 5
"""The fewest boxes for a sentence on boxes like these."""

MOST_EXACT = 200
"""Pairs up to which the test of equivalence is exact; beyond, its statistic is approximately normal, and at a margin of
10 points it is wrong in at most 5.4 % of studies."""

ONE_BOX: NDArray[np.str_] = np.empty(0, dtype=np.str_)
"""The boxes of pairs that are all on one."""

_SHARES = 60
"""Shares of pairs that differ for which the exact test is computed; it takes the largest P value."""

_TIE = 1e-9

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Pairs:
    """Pairs by box, each column of shape (boxes,).

    Attributes:
        first, second: Pairs solved under the first condition alone, and under the second alone.
        n: Pairs; at least one on each of several boxes.
    """

    first: Array
    second: Array
    n: Array

    @property
    def differences(self) -> Array:
        """Success under the second condition minus that under the first, of each box."""
        return (self.second - self.first) / self.n


@dataclass(frozen=True, slots=True, kw_only=True)
class Paired(Difference):
    """The paired difference of two conditions: the share solved under the second minus that under the first.

    Attributes:
        only_first, only_second: Pairs solved under the first condition alone, and under the second alone.
        p_value: McNemar's exact test, two-sided; 1 if no pair differs.
        interval_p: The P value of the interval: below 0.05 if one at 95 % leaves out 0.
    """

    only_first: int
    only_second: int
    p_value: float
    interval_p: float


def paired(first: NDArray[np.bool_], second: NDArray[np.bool_], *, choices: int = 1) -> Paired:
    """The difference between two conditions on the same trials of one box, shape (pairs,), for any shared luck."""
    counts = np.count_nonzero(first & ~second), np.count_nonzero(second & ~first), len(first)
    one, two, n = (np.array([float(many)]) for many in counts)
    return difference_over_boxes(Pairs(first=one, second=two, n=n), choices=choices)


def pairs_by_box(solved: NDArray[np.bool_], box: NDArray[np.str_] = ONE_BOX) -> Pairs:
    """Pairs of trials by box, boxes in the order of their names; ``box`` is empty if all are on one.

    ``solved`` says whether the trials of a pair were solved under each of two conditions, shape (pairs, 2).
    """
    place = np.unique(box, return_inverse=True)[1].reshape(-1) if len(box) else np.zeros(len(solved), dtype=np.int64)
    first, second = solved.T
    columns = (first & ~second, second & ~first, np.ones(len(solved)))
    one, two, n = (np.bincount(place, weights=of, minlength=1).astype(np.float64) for of in columns)
    return Pairs(first=one, second=two, n=n)


def difference_over_boxes(pairs: Pairs, *, choices: int = 1) -> Paired:
    """The mean difference of boxes: of boxes like these from :data:`FEWEST` boxes on, else of these.

    ``choices`` differences are judged together: the interval has the level 1 - 0.05 / choices.
    """
    k, n, tail = len(pairs.n), float(pairs.n.sum()), (1 - LEVEL) / choices
    weights, effect = np.ones(k), 1.0
    if k > 1:
        weights = n / (k * pairs.n)
        effect = float(np.sum(pairs.n * weights**2)) / n
    only = float(weights @ pairs.first), float(weights @ pairs.second)
    middle = (only[1] - only[0]) / (n + 2)  # half a pair is added to each of the four cells
    error = math.sqrt(effect * ((sum(only) + 1) / (n + 2) - middle**2) / (n + 2))
    half = -normal_quantile(tail / 2) * error
    ends, tests = [(middle - half, middle + half)], [2 * NormalDist().cdf(-abs(middle) / error)]

    def few_differ(first: int, second: int, all_: int) -> None:
        ends.append(score_interval(first, second, all_, 1 - tail))
        tests.append(2 * NormalDist().cdf(-abs(float(score(first, second, all_, 0.0)))))

    one, two = int(pairs.first.sum()), int(pairs.second.sum())
    if n and one + two <= FEW:
        few_differ(one, two, int(n))
    if k >= FEWEST:
        low, high, p_value = student_mean(pairs.differences, 1 - tail)
        ends.append((low, high))
        tests.append(p_value)
        if np.sum(pairs.first + pairs.second > 0) <= min(FEW, k / 2):
            few_differ(int(np.sum(pairs.differences < 0)), int(np.sum(pairs.differences > 0)), k)
    lows, highs = zip(*ends, strict=True)
    return Paired(
        only_first=one,
        only_second=two,
        n=int(n),
        value=(only[1] - only[0]) / n if n else math.nan,
        low=max(-1.0, min(lows)),
        high=min(1.0, max(highs)),
        p_value=sign_test(one, two),
        interval_p=min(1.0, max(tests)),
    )


def score(only_first: ArrayLike, only_second: ArrayLike, pairs: int, change: float) -> Array:
    """Tango's score statistic of a difference, standard normal if it is ``change``, (-1, 1); negative below it."""
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
    z, value, end = -normal_quantile((1 - level) / 2), (only_second - only_first) / pairs, 1 - 1e-9

    def above(change: float, by: float) -> float:
        return float(score(only_first, only_second, pairs, change)) - by

    low = root(lambda change: above(change, z), -end, value) if value > -end and above(-end, z) > 0 else -1.0
    high = root(lambda change: above(change, -z), value, end) if value < end and above(end, -z) < 0 else 1.0
    return low, high


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
