"""Shares of trials with their intervals, and the difference of two independent shares."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from statistics import NormalDist

from lockprobe.statistics.distributions import fisher_exact

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
        value: ``count / n``, [0, 1]; NaN if ``n`` is 0. Of several boxes the mean of theirs.
        low, high: Ends of the interval; 0 and 1 if ``n`` is 0. With broken trials it holds whatever became of them.
        broken: Trials that were begun beside these and broke.
        clusters: Clusters with a trial, where these are counted.
        design_effect: Variance over that of ``n`` independent trials, >= 1.
    """

    count: int
    n: int
    value: float
    low: float
    high: float
    broken: int = 0
    clusters: int | None = None
    design_effect: float = 1.0

    @property
    def bounds(self) -> tuple[float, float]:
        """The share of all begun trials if those that broke were all failures, and if they were all successes."""
        begun = self.n + self.broken
        return self.count / begun, (self.count + self.broken) / begun


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """A difference, or a mean of differences, NaN without any, with what could be estimated of it.

    Attributes:
        low, high: Ends of its 95 % interval, or of a wider one that allows for several; None where there is none.
        p_value: Two-sided; None where nothing was tested.
        n: Trials, or pairs of trials, that it is of.
        clusters: Blocks of luck, people or trials that these come in, where they are counted.
    """

    value: float
    low: float | None = None
    high: float | None = None
    p_value: float | None = None
    n: int = 0
    clusters: int | None = None

    @property
    def clear(self) -> bool:
        """Whether there is an interval and it excludes 0."""
        return self.low is not None and self.high is not None and (self.low > 0 or self.high < 0)

    def detected(self, level: float = ALPHA) -> bool:
        """Whether the test rejects and the interval excludes 0."""
        return self.p_value is not None and self.p_value < level and self.clear


@lru_cache(maxsize=65536)
def proportion(count: int, n: int) -> Proportion:
    """A share with Wilson's interval.

    >>> round(proportion(7, 30).low, 3), round(proportion(7, 30).high, 3)
    (0.118, 0.409)
    """
    if n == 0:
        return Proportion(count=0, n=0, value=math.nan, low=0.0, high=1.0)
    low, high = wilson(count / n, n)
    return Proportion(count=count, n=n, value=count / n, low=low, high=high)


def between(known: Proportion, none: Proportion, every: Proportion) -> Proportion:
    """A share of known outcomes, with an interval that holds whatever the others are.

    ``none`` and ``every`` are the shares of all trials with the others as failures, and as successes.
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
    """Two independent shares compared by Newcombe's interval and Fisher's exact test; None if one has no trials.

    Conditions of one study share their luck (common random numbers). If that luck acts alike in both, interval and test
    are conservative. With broken trials both hold whatever became of them: those of the one and of the other end, at
    which one share is as large and the other as small as it can be.
    """
    if first.n == 0 or second.n == 0:
        return None
    value = second.value - first.value
    if first.broken or second.broken:
        low, high = (found for ends in opposed_shares(first, second) if (found := difference(*ends)))
        p_value = max(low.p_value or 0.0, high.p_value or 0.0) if low.value * high.value > 0 else 1.0
        return Difference(value=value, low=low.low, high=high.high, p_value=p_value)
    first, second = proportion(first.count, first.n), proportion(second.count, second.n)
    down = math.hypot(second.value - second.low, first.high - first.value)
    up = math.hypot(second.high - second.value, first.value - first.low)
    p_value = fisher_exact([[second.count, second.n - second.count], [first.count, first.n - first.count]])
    return Difference(value=value, low=max(-1.0, value - down), high=min(1.0, value + up), p_value=p_value)


def opposed_shares(first: Proportion, second: Proportion) -> list[tuple[Proportion, Proportion]]:
    """The two shares of all begun trials where second minus first is smallest, and where it is largest.

    The shares themselves if no trial broke.
    """
    if not (first.broken or second.broken):
        return [(first, second)]
    (first_low, first_high), (second_low, second_high) = (
        [proportion(one.count + solved * one.broken, one.n + one.broken) for solved in (0, 1)]
        for one in (first, second)
    )
    return [(first_high, second_low), (first_low, second_high)]
