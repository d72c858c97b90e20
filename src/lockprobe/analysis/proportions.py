"""Shares, how sure they are, and how far two of them lie apart."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from statistics import NormalDist
from typing import Literal

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Difference",
    "ExactTests",
    "Paired",
    "Proportion",
    "Ratio",
    "difference",
    "exact_tests",
    "paired",
    "proportion",
    "ratio",
]

ALPHA = 0.05
"""Level of every test."""

LEVEL = 0.95
"""Confidence level of every interval."""

Z = NormalDist().inv_cdf((1 + LEVEL) / 2)
"""Its normal quantile."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Proportion:
    """A share with its 95 % interval, Wilson's unless asked otherwise.

    Attributes:
        count: How many.
        n: Of how many.
        value: ``count / n``, [0, 1]; not a number if ``n`` is 0.
        low: Lower end, [0, 1]; 0 if ``n`` is 0.
        high: Upper end, [0, 1]; 1 if ``n`` is 0.
    """

    count: int
    n: int
    value: float
    low: float
    high: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """How far two independent proportions lie apart.

    Attributes:
        value: Second minus first, [-1, 1].
        low: Lower end of the 95 % interval (Newcombe's, from the two Wilson intervals).
        high: Upper end.
        p_value: Two-sided Fisher's exact test.
    """

    value: float
    low: float
    high: float
    p_value: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Ratio:
    """How many times the first of two independent proportions the second is.

    Attributes:
        value: Second over first, >= 0.
        low: Lower end of the 95 % interval.
        high: Upper end.
    """

    value: float
    low: float
    high: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ExactTests:
    """Two-sided exact p-values for two independent proportions.

    Attributes:
        fisher: Given both margins; errs on the safe side.
        boschloo: Given the two sample sizes, with Fisher's p-value as statistic: never larger than Fisher's one-sided
            test doubled.
        barnard: Given the two sample sizes, with the pooled z as statistic.
    """

    fisher: float
    boschloo: float
    barnard: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Paired:
    """Trials met twice with the same luck, where the two outcomes differ.

    Attributes:
        only_first: Pairs solved the first time alone.
        only_second: Pairs solved the second time alone.
        n: Pairs.
        value: Share solved the second time less the first, [-1, 1]; not a number without pairs.
        low: Lower end of the interval of the difference, second less first (Agresti & Min 2005), [-1, 1].
        high: Upper end.
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
        """The p-value that belongs to the interval: below 0.05 if one at 95 % leaves out 0."""
        middle, error = _agresti_min(self.only_first, self.only_second, self.n)
        return min(1.0, 2 * NormalDist().cdf(-abs(middle) / error))


@lru_cache(maxsize=65536)
def proportion(count: int, n: int, level: float = LEVEL, method: Literal["wilson", "exact"] = "wilson") -> Proportion:
    """A share with its interval.

    Args:
        count: How many, 0 to ``n``.
        n: Of how many; 0 gives the interval [0, 1].
        level: Confidence level, (0, 1).
        method: Wilson's interval, which holds the level on average, or Clopper & Pearson's, which never falls below it.

    >>> round(proportion(7, 30).low, 3), round(proportion(7, 30).high, 3)
    (0.118, 0.409)
    >>> round(proportion(7, 30, method="exact").low, 3), round(proportion(7, 30, method="exact").high, 3)
    (0.099, 0.423)
    """
    if n == 0:
        return Proportion(count=0, n=0, value=math.nan, low=0.0, high=1.0)
    from scipy.stats import binomtest

    interval = binomtest(count, n).proportion_ci(confidence_level=level, method=method)
    low, high = max(0.0, float(interval.low)), min(1.0, float(interval.high))
    return Proportion(count=count, n=n, value=count / n, low=low if count else 0.0, high=high if count < n else 1.0)


def difference(first: Proportion, second: Proportion, *, choices: int = 1) -> Difference | None:
    """How far the second proportion lies above the first; None if one of them has no trials.

    The two are taken as independent. Conditions of one study share their luck (common random numbers), which
    makes the interval and the test wider than they need be, not narrower, where that luck acts alike in both.

    Args:
        first: Success under one condition.
        second: Success under another.
        choices: Number of conditions that the second was chosen from; the interval has the level 1 - 0.05 / choices.
    """
    if first.n == 0 or second.n == 0:
        return None
    from scipy.stats import fisher_exact

    value = second.value - first.value
    level = 1 - (1 - LEVEL) / choices
    first, second = proportion(first.count, first.n, level), proportion(second.count, second.n, level)
    down = math.hypot(second.value - second.low, first.high - first.value)
    up = math.hypot(second.high - second.value, first.value - first.low)
    table = np.array([[second.count, second.n - second.count], [first.count, first.n - first.count]])
    return Difference(
        value=value,
        low=max(-1.0, value - down),
        high=min(1.0, value + up),
        p_value=float(fisher_exact(table).pvalue),
    )


def exact_tests(first: Proportion, second: Proportion) -> ExactTests | None:
    """Whether two independent proportions differ; None if one of them has no trials.

    >>> tests = exact_tests(proportion(7, 30), proportion(20, 30))
    >>> round(tests.fisher, 4), round(tests.boschloo, 4), round(tests.barnard, 4)
    (0.0016, 0.0008, 0.0008)
    """
    if first.n == 0 or second.n == 0:
        return None
    if first.count + second.count in {0, first.n + second.n}:
        return ExactTests(fisher=1.0, boschloo=1.0, barnard=1.0)
    from scipy.stats import barnard_exact, boschloo_exact, fisher_exact

    table = np.array([[second.count, first.count], [second.n - second.count, first.n - first.count]])
    return ExactTests(
        fisher=float(fisher_exact(table).pvalue),
        boschloo=min(1.0, float(boschloo_exact(table).pvalue)),
        barnard=min(1.0, float(barnard_exact(table).pvalue)),
    )


def ratio(first: Proportion, second: Proportion, method: Literal["score", "log"] = "score") -> Ratio | None:
    """How many times the first proportion the second is; None where that, or the log interval, is not finite.

    Args:
        first: Success under one condition.
        second: Success under another.
        method: Miettinen & Nurminen's score interval, or Katz's normal interval of the logarithm, which is narrower
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
    # statsmodels 0.15 gives the estimate itself as a limit where every trial of a sample is solved.
    middle, far = math.log(value) if value else -30.0, 30.0
    low = math.exp(brentq(lambda x: _ratio_score(first, second, math.exp(x)) - z, -far, middle)) if value else 0.0
    high = math.exp(brentq(lambda x: _ratio_score(first, second, math.exp(x)) + z, middle, far))
    return Ratio(value=value, low=low, high=high)


def _ratio_score(first: Proportion, second: Proportion, value: float) -> float:
    """How far the second proportion lies above ``value`` times the first, in standard errors under that ratio."""
    total, solved = first.n + second.n, first.count + second.count
    square, linear = total * value, second.n * value + second.count + first.n + first.count * value
    base = (linear - math.sqrt(max(0.0, linear**2 - 4 * square * solved))) / (2 * square)
    base = min(base, 1.0, 1 / value)
    variance = value * base * (1 - value * base) / second.n + value**2 * base * (1 - base) / first.n
    away = second.value - value * first.value
    return away / math.sqrt(variance * total / (total - 1)) if variance > 0 else 0.0


def paired(first: NDArray[np.bool_], second: NDArray[np.bool_], *, choices: int = 1) -> Paired:
    """Whether two outcomes of the same trials differ, and how far, whatever luck they share.

    Args:
        first: Whether each trial was solved under one condition, shape (pairs,).
        second: The same trials under another condition.
        choices: Number of conditions that the second was chosen from; the interval has the level 1 - 0.05 / choices.
    """
    from scipy.stats import binomtest, norm

    one, two = int(np.sum(first & ~second)), int(np.sum(second & ~first))
    (middle, error), z = _agresti_min(one, two, len(first)), float(norm.isf((1 - LEVEL) / choices / 2))
    return Paired(
        only_first=one,
        only_second=two,
        n=len(first),
        value=(two - one) / len(first) if len(first) else math.nan,
        low=max(-1.0, middle - z * error),
        high=min(1.0, middle + z * error),
        p_value=float(binomtest(one, one + two).pvalue) if one + two else 1.0,
    )


def _agresti_min(only_first: int, only_second: int, pairs: int) -> tuple[float, float]:
    """The middle of their interval and its standard error, with half a pair more of each of the four kinds."""
    n = pairs + 2
    middle = (only_second - only_first) / n
    return middle, math.sqrt((only_first + only_second + 1) / n - middle**2) / math.sqrt(n)
