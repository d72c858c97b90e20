"""The share of one mean paired difference in another, with its interval (Fieller 1954).

A share of 1 says that the first difference equals the second. Its interval holds every share r for which the mean of
``first - r * second`` over blocks is not distinguished from 0 by Student's test. It is bounded if and only if the mean
of the second is distinguished from 0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from lockprobe.statistics.agent_comparison.paired import Array
from lockprobe.statistics.distributions import student_quantile
from lockprobe.statistics.proportions import LEVEL

__all__ = ["HALF", "Share", "Verdict", "share_of"]

HALF = 0.5
"""A share counts as the whole if its interval holds 1 and lies above one half, as none if it holds 0 and lies below
one half. The line is ours."""

Verdict = Literal["all", "part", "none", "more", "opposite", "not decided"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Share:
    """A share with its interval.

    Attributes:
        value: First mean over second mean.
        low, high: Ends of the interval; None if it is not bounded.
    """

    value: float
    low: float | None
    high: float | None

    @property
    def verdict(self) -> Verdict:
        """What the interval decides: all of the difference, a part, none, more than all, or the opposite of it."""
        if self.low is None or self.high is None:
            return "not decided"
        if self.low > 1:
            return "more"
        if self.high < 0:
            return "opposite"
        if self.low > HALF and self.high >= 1:
            return "all"
        if self.high < HALF and self.low <= 0:
            return "none"
        return "part" if self.low > 0 and self.high < 1 else "not decided"


def share_of(first: Array, second: Array, level: float = LEVEL) -> Share:
    """The share of the mean of ``first`` in the mean of ``second``, over the same blocks.

    The variance holds one block more in which the first differs as the second does on average (root mean square), so
    that the interval has a width even if both are equal in every block; as Agresti and Min (2005) for shares.

    Args:
        first: A difference of each block, shape (blocks,), at least two.
        second: The other difference of each block.
        level: Confidence level, (0, 1).
    """
    n, a, b = len(first), float(first.mean()), float(second.mean())
    away, beyond = first - a, second - b
    k = student_quantile((1 + level) / 2, n - 1) ** 2 / (n * (n - 1))
    more = float(np.mean(second**2))
    value = a / b if b else math.nan
    # b² r² - 2abr + a² <= k (S_aa + more - 2 r S_ab + r² S_bb)
    square = b * b - k * float(beyond @ beyond)
    line = a * b - k * float(away @ beyond)
    rest = a * a - k * (float(away @ away) + more)
    if square <= 0:
        return Share(value=value, low=None, high=None)
    half = math.sqrt(max(0.0, line * line - square * rest))
    return Share(value=value, low=(line - half) / square, high=(line + half) / square)
