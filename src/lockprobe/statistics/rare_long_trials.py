"""Mean differences in steps where a rare block takes the whole budget, and a small sample may hold none.

An agent that is mostly a little faster and now and then needs its whole budget is no faster, and a sample without such
a trial has neither its mean nor its spread. So three more blocks are added to the variance, as Agresti and Min (2005)
add pairs that differ to shares. In each, one of the two takes the whole budget, or as few steps as the shortest trial,
and the other what it takes on average, whichever is farther.

Three are enough for every budget. Rare blocks have a Poisson distribution. A decrease is said after k of them if more
than k + 1.96 sqrt(k + 3) were to be expected, and at most 5 % of samples have so few.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from lockprobe.statistics.distributions import student_quantile, student_tails
from lockprobe.statistics.proportions import LEVEL

BLOCKS = 3
"""Blocks that are added to the variance."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RareBlock:
    """How far below and above a mean difference in steps a rare block may lie."""

    below: float
    above: float

    def interval(
        self, value: float, se: float, clusters: int, *, share: float | None = None, level: float = LEVEL
    ) -> tuple[float, float]:
        """Student's interval of a mean difference, with rare blocks in its variance.

        Args:
            value: The mean difference in the sample.
            se: Its standard error.
            clusters: Blocks of the sample, or people where there are fewer; at least two.
            share: Size of a rare block as a share of the sample; by default that of one of equal blocks.
            level: Confidence level.
        """
        quantile, share = student_quantile((1 + level) / 2, clusters - 1), share or 1 / clusters
        return value - quantile * _wider(se, share * self.below), value + quantile * _wider(se, share * self.above)

    def p_value(self, value: float, se: float, clusters: int, *, share: float | None = None) -> float:
        """That the difference is 0, two-sided; below 0.05 if the interval at 95 % excludes 0."""
        error = _wider(se, (share or 1 / clusters) * (self.below if value > 0 else self.above))
        return float(student_tails(value / error, clusters - 1))


def _wider(se: float, one: float) -> float:
    return math.sqrt(se**2 + BLOCKS * one**2)


def rare_block(first: float, second: float, budget: float, shortest: float) -> RareBlock:
    """How far a rare block may lie from the difference in steps of two agents, or of one under two conditions.

    Args:
        first: Mean steps of the first; an unsolved trial counts with the whole budget.
        second: Mean steps of the second, from which those of the first are taken.
        budget: Steps of a trial.
        shortest: Steps of the shortest trial of both. A rare one is taken to be as short, or a fifth of the budget.
    """
    least = min(shortest, budget / 5)
    return RareBlock(
        below=max(budget - second, first - least, 1.0),
        above=max(budget - first, second - least, 1.0),
    )
