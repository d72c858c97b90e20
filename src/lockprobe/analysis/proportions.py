"""Shares, how sure they are, and how far two of them lie apart."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

__all__ = ["Difference", "Proportion", "difference", "proportion"]

LEVEL = 0.95
"""Confidence level of every interval."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Proportion:
    """A share with its 95 % Wilson interval.

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


@lru_cache(maxsize=65536)
def proportion(count: int, n: int, level: float = LEVEL) -> Proportion:
    """A share with its Wilson interval.

    Args:
        count: How many, 0 to ``n``.
        n: Of how many; 0 gives the interval [0, 1].
        level: Confidence level, (0, 1).

    >>> round(proportion(7, 30).low, 3), round(proportion(7, 30).high, 3)
    (0.118, 0.409)
    """
    if n == 0:
        return Proportion(count=0, n=0, value=math.nan, low=0.0, high=1.0)
    from scipy.stats import binomtest

    interval = binomtest(count, n).proportion_ci(confidence_level=level, method="wilson")
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
