"""Proportions with confidence intervals: single, and their difference, ratio and paired difference."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from statistics import NormalDist
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.distributions import binomial_interval, fisher_exact, normal_quantile, sign_test
from lockprobe.statistics.paired_proportions import FEW, score, score_interval

ALPHA = 0.05
"""Level of every test."""

LEVEL = 0.95
"""Confidence level of every interval."""

Z = NormalDist().inv_cdf((1 + LEVEL) / 2)
"""The normal quantile of :data:`LEVEL`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Proportion:
    """A share with its 95 % interval, by default Wilson's.

    Attributes:
        count: Successes.
        n: Trials whose outcome is known.
        value: ``count / n``, [0, 1]; NaN if ``n`` is 0.
        low, high: Ends of the interval; 0 and 1 if ``n`` is 0. With broken trials it holds whatever became of them.
        broken: Trials that were begun beside these and broke.
    """

    count: int
    n: int
    value: float
    low: float
    high: float
    broken: int = 0

    @property
    def bounds(self) -> tuple[float, float]:
        """The share of all begun trials if those that broke were all failures, and if they were all successes."""
        begun = self.n + self.broken
        return self.count / begun, (self.count + self.broken) / begun


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """The difference of two independent proportions.

    Attributes:
        value: Second minus first, [-1, 1].
        low, high: Ends of Newcombe's 95 % interval, from the two Wilson intervals.
        p_value: Two-sided Fisher's exact test.
    """

    value: float
    low: float
    high: float
    p_value: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Ratio:
    """The ratio of two independent proportions.

    Attributes:
        value: Second over first, >= 0.
        low, high: Ends of the 95 % interval.
    """

    value: float
    low: float
    high: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Paired:
    """The paired difference of two conditions, over pairs of trials with the same luck (McNemar's design).

    Attributes:
        only_first: Pairs solved under the first condition alone.
        only_second: Pairs solved under the second condition alone.
        n: Pairs.
        value: Share solved under the second condition minus the first, [-1, 1]; NaN without pairs.
        low, high: Ends of the interval of ``value`` (Agresti & Min 2005), [-1, 1]. If five pairs or fewer differ, it
            also holds Tango's score interval, which does not shrink with the pairs that differ.
        p_value: McNemar's exact test, two-sided; 1 if no pair differs.
    """

    only_first: int
    only_second: int
    n: int
    value: float
    low: float
    high: float
    p_value: float

    @property
    def interval_p(self) -> float:
        """The P value of the interval: below 0.05 if the 95 % interval excludes 0."""
        middle, error = _agresti_min(self.only_first, self.only_second, self.n)
        away = abs(middle) / error
        if self.n and self.only_first + self.only_second <= FEW:
            away = min(away, abs(float(score(self.only_first, self.only_second, self.n, 0.0))))
        return min(1.0, 2 * NormalDist().cdf(-away))


@lru_cache(maxsize=65536)
def proportion(count: int, n: int, level: float = LEVEL, method: Literal["wilson", "exact"] = "wilson") -> Proportion:
    """A share with its interval.

    Args:
        count: Successes, 0 to ``n``.
        n: Trials; 0 gives the interval [0, 1].
        level: Confidence level, (0, 1).
        method: Wilson's interval, with the right average coverage, or ``exact`` (Clopper & Pearson), never below it.

    >>> round(proportion(7, 30).low, 3), round(proportion(7, 30).high, 3)
    (0.118, 0.409)
    >>> round(proportion(7, 30, method="exact").low, 3), round(proportion(7, 30, method="exact").high, 3)
    (0.099, 0.423)
    """
    if n == 0:
        return Proportion(count=0, n=0, value=math.nan, low=0.0, high=1.0)
    if method == "wilson":
        low, high = wilson(count / n, n, NormalDist().inv_cdf((1 + level) / 2))
        return Proportion(count=count, n=n, value=count / n, low=low, high=high)
    low, high = binomial_interval(count, n, level)
    return Proportion(count=count, n=n, value=count / n, low=low, high=high)


def between(known: Proportion, none: Proportion, every: Proportion) -> Proportion:
    """A share of known outcomes, with an interval that holds them and whatever the others are.

    Args:
        known: The share of the known ones.
        none: The share of all trials, with the others as failures.
        every: The same with them as successes.
    """
    low, high = min(none.low, known.value), max(every.high, known.value)
    return replace(known, low=low, high=high, broken=every.n - known.n)


def wilson(share: float, n: float, z: float = Z, *, design_effect: float = 1.0) -> tuple[float, float]:
    """The ends of Wilson's interval (1927), exactly 0 at a share of 0 and 1 at a share of 1.

    Args:
        share: Share of successes, [0, 1].
        n: Trials, at least 0; it may be a fraction. 0 gives the interval [0, 1].
        z: Half the width of an interval of the same level, in standard errors.
        design_effect: Variance over that of independent trials, above 0.
    """
    if n == 0:
        return 0.0, 1.0
    squared = z**2 * design_effect / n
    middle = (share + squared / 2) / (1 + squared)
    half = math.sqrt(squared * share * (1 - share) + squared**2 / 4) / (1 + squared)
    return max(0.0, middle - half) if share > 0 else 0.0, min(1.0, middle + half) if share < 1 else 1.0


def difference(first: Proportion, second: Proportion) -> Difference | None:
    """The second proportion minus the first, taken as independent; None if one of them has no trials.

    Conditions of one study share their luck (common random numbers). If that luck acts alike in both, interval and test
    are conservative. With broken trials the interval and the P value hold whatever became of them: those of the one and
    of the other end, at which one proportion is as large and the other as small as it can be.
    """
    if first.n == 0 or second.n == 0:
        return None
    if first.broken or second.broken:
        low, high = (found for ends in opposed_shares(first, second) if (found := difference(*ends)))
        return Difference(
            value=second.value - first.value,
            low=low.low,
            high=high.high,
            p_value=max(low.p_value, high.p_value) if low.value * high.value > 0 else 1.0,
        )
    value = second.value - first.value
    first, second = proportion(first.count, first.n), proportion(second.count, second.n)
    down = math.hypot(second.value - second.low, first.high - first.value)
    up = math.hypot(second.high - second.value, first.value - first.low)
    table = [[second.count, second.n - second.count], [first.count, first.n - first.count]]
    return Difference(
        value=value,
        low=max(-1.0, value - down),
        high=min(1.0, value + up),
        p_value=fisher_exact(table),
    )


def opposed_shares(first: Proportion, second: Proportion) -> list[tuple[Proportion, Proportion]]:
    """The two shares of all begun trials where second minus first is smallest, and where it is largest.

    The shares themselves if no trial broke.
    """
    if not (first.broken or second.broken):
        return [(first, second)]
    ends = [
        [proportion(one.count + solved * one.broken, one.n + one.broken) for solved in (0, 1)]
        for one in (first, second)
    ]
    (first_low, first_high), (second_low, second_high) = ends
    return [(first_high, second_low), (first_low, second_high)]


def ratio(first: Proportion, second: Proportion, method: Literal["score", "log"] = "score") -> Ratio | None:
    """The second proportion over the first; None if the ratio, or the log interval, is not finite.

    The interval is Miettinen & Nurminen's score interval, or Katz's normal interval of the logarithm, which is narrower
    and needs a success on either side.
    """
    if first.n == 0 or second.n == 0 or first.count == 0 or (method == "log" and second.count == 0):
        return None
    from scipy.optimize import brentq
    from scipy.special import ndtri

    value, z = second.value / first.value, float(ndtri((1 + LEVEL) / 2))
    if method == "log":
        spread = z * math.sqrt((1 - first.value) / first.count + (1 - second.value) / second.count)
        return Ratio(value=value, low=value * math.exp(-spread), high=value * math.exp(spread))
    middle, far = math.log(value) if value else -30.0, 30.0
    low = math.exp(brentq(lambda x: _ratio_score(first, second, math.exp(x)) - z, -far, middle)) if value else 0.0
    high = math.exp(brentq(lambda x: _ratio_score(first, second, math.exp(x)) + z, middle, far))
    return Ratio(value=value, low=low, high=high)


def _ratio_score(first: Proportion, second: Proportion, value: float) -> float:
    """The score statistic: second proportion minus ``value`` times the first, in standard errors under that ratio."""
    total, solved = first.n + second.n, first.count + second.count
    square, linear = total * value, second.n * value + second.count + first.n + first.count * value
    base = (linear - math.sqrt(max(0.0, linear**2 - 4 * square * solved))) / (2 * square)
    base = min(base, 1.0, 1 / value)
    variance = value * base * (1 - value * base) / second.n + value**2 * base * (1 - base) / first.n
    away = second.value - value * first.value
    return away / math.sqrt(variance * total / (total - 1)) if variance > 0 else 0.0


def paired(first: NDArray[np.bool_], second: NDArray[np.bool_], *, choices: int = 1) -> Paired:
    """The paired difference between two conditions on the same trials, valid for any shared luck.

    Args:
        first: Whether each trial was solved under one condition, shape (pairs,).
        second: The same for the other condition.
        choices: Number of conditions that the second was chosen from; the interval has the level 1 - 0.05 / choices.
    """
    one, two = int(np.sum(first & ~second)), int(np.sum(second & ~first))
    (middle, error), z = _agresti_min(one, two, len(first)), -normal_quantile((1 - LEVEL) / choices / 2)
    low, high = max(-1.0, middle - z * error), min(1.0, middle + z * error)
    if len(first) and one + two <= FEW:
        ends = score_interval(one, two, len(first), 1 - (1 - LEVEL) / choices)
        low, high = min(low, ends[0]), max(high, ends[1])
    return Paired(
        only_first=one,
        only_second=two,
        n=len(first),
        value=(two - one) / len(first) if len(first) else math.nan,
        low=low,
        high=high,
        p_value=sign_test(one, two),
    )


def _agresti_min(only_first: int, only_second: int, pairs: int) -> tuple[float, float]:
    """Centre and standard error of Agresti and Min's interval: half a pair is added to each of the four cells."""
    n = pairs + 2
    middle = (only_second - only_first) / n
    return middle, math.sqrt((only_first + only_second + 1) / n - middle**2) / math.sqrt(n)
