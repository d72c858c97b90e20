"""Differences and shares that hold at every look: several means judged together, block by block.

Each mean is tested for an effect (it is not 0) and, with a margin, for being small (it lies within the margin). All of
these statements are one family, corrected by closed testing: a mean cannot be 0 and as large as the margin, so that of
each mean one of the two hypotheses counts, that with less evidence against it. Once a statement is made it stays: P
values are the smallest of all looks, and intervals lie within those before.

The mean of e-values is an e-value of the hypothesis that all of their hypotheses hold, however they depend on each
other. So a hypothesis is rejected if every set of hypotheses that it is in has a mean e-value of 20 or more (closed
testing; Vovk and Wang, Annals of Statistics 2021, Sec. 6). One that is true is then rejected in at most 5 % of studies,
whichever of the others are true, at any look. The sets that decide hold the smallest other e-values.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lockprobe.statistics.betting import SHARES, Side, confidence_sequence, log_wealth, looks
from lockprobe.statistics.broken_trials import bounded
from lockprobe.statistics.proportions import ALPHA, Proportion

Array = NDArray[np.float64]

E_PROCESS = "e-process"
"""What tables call a test that holds at every look."""

_LARGEST = 600.0
"""Logarithm of the largest e-value that is told apart from larger ones."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Numbers:
    """Numbers whose mean is asked for, one for each block that has one.

    Attributes:
        values: The numbers in the order of the blocks, each in [-bound, bound], shape (numbers,).
        block: Place of the block of each, ascending, from 0, shape (numbers,).
        bound: The largest size that a number can have.
    """

    values: Array
    block: NDArray[np.int64]
    bound: float = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class AtEveryLook:
    """A mean after each block, tested at every look.

    Attributes:
        n: Numbers.
        value: Their mean; NaN without any.
        low, high: Ends of the interval at the last look, [-bound, bound].
        p_value: P value of "the mean is 0", corrected for the family and for agents; 1 without numbers.
        effect_at: Number of the block (from 1) at which the interval left out 0 for the first time; None if at none.
        small_p_value: P value of "the mean is as large as the margin or larger, either way"; 1 without a margin.
        small_at: Number of the block at which that P value fell below 0.05; None if at none.
        blocks: Numbers of blocks (from 1) at which the interval is kept, ascending, shape (looks,).
        means, lows, highs: Mean and ends of the interval there, of the same shape.
        halves: Means of the first and of the second half of the numbers; NaN where a half is empty.
    """

    n: int
    value: float
    low: float
    high: float
    p_value: float
    effect_at: int | None
    small_p_value: float
    small_at: int | None
    blocks: NDArray[np.int64]
    means: Array
    lows: Array
    highs: Array
    halves: tuple[float, float]

    @property
    def way(self) -> int:
        """The sign of the mean at ``effect_at``; 0 without."""
        return 0 if self.effect_at is None else int(np.sign(self.means[self.blocks == self.effect_at][0]))

    def narrow_at(self, half_width: float) -> int | None:
        """The block (from 1) from which on the interval reaches no further than this to either side; None if none."""
        found = np.flatnonzero(self.highs - self.lows <= 2 * half_width + 1e-9)
        return int(self.blocks[found[0]]) if len(found) else None


def at_every_look(
    family: Sequence[Numbers], *, agents: float = 1, margin: float | None = None
) -> tuple[AtEveryLook, ...]:
    """Judge several means together.

    Args:
        family: The numbers of each mean. What has no number at a block keeps the e-value that it had before.
        agents: Number of such families that are judged together (Bonferroni).
        margin: With a margin it is also tested whether a mean is smaller than it, either way. Any statement of the two
            kinds is then false in at most 5 % of studies.
    """
    p_values, small, limits = _tested(family, agents, margin)
    return tuple(_judged(one, p_values[:, i], limits[:, i], small[:, i]) for i, one in enumerate(family))


def held_at_both_ends(found: AtEveryLook, low: AtEveryLook, high: AtEveryLook) -> AtEveryLook:
    """A course without the broken trials, with what holds at both ends of what these can have become.

    The ends have a number for every begun block; the course runs over these, through the middle of both means.
    """
    effects, smalls = ([getattr(one, name) for one in (low, high)] for name in ("effect_at", "small_at"))
    return replace(
        bounded(found, low, high),
        effect_at=max(effects) if None not in effects and low.value * high.value > 0 else None,
        small_p_value=max(low.small_p_value, high.small_p_value),
        small_at=None if None in smalls else max(smalls),
        blocks=low.blocks,
        means=(low.means + high.means) / 2,
        lows=np.minimum(low.lows, high.lows),
        highs=np.maximum(low.highs, high.highs),
    )


def share_at_every_look(solved: ArrayLike) -> Proportion:
    """A share with its confidence sequence, from a mixture of binomial likelihood ratios (Robbins 1970).

    ``solved`` says whether each trial was solved, in the order of blocks, shape (trials,); NaN where it broke. The
    interval is then from the low end with all of these unsolved to the high end with all solved.

    >>> found = share_at_every_look([i % 4 == 3 for i in range(30)])
    >>> round(found.low, 2), round(found.high, 2)
    (0.06, 0.51)
    """
    values = np.asarray(solved, dtype=np.float64)
    known = values[~np.isnan(values)]
    ends = (known,) if len(known) == len(values) else (np.nan_to_num(values, nan=0.0), np.nan_to_num(values, nan=1.0))
    courses = [confidence_sequence(one, math.log(1 / ALPHA), bets=SHARES) for one in ends]
    lows, highs = courses[0][0], courses[-1][1]
    return Proportion(
        count=int(known.sum()),
        n=len(known),
        value=_mean(known),
        low=float(lows[-1]) if len(lows) else 0.0,
        high=float(highs[-1]) if len(highs) else 1.0,
        broken=len(values) - len(known),
    )


def _tested(family: Sequence[Numbers], agents: float, margin: float | None) -> tuple[Array, Array, Array]:
    """P values of an effect and of being small, and the logarithms of what an e-value must exceed: (blocks, means)."""

    def wealth(one: Numbers, mean: float, side: Side = "both") -> Array:
        return log_wealth(one.values, mean, low=-one.bound, high=one.bound, side=side)

    def tested(log_e: Array) -> tuple[Array, Array]:
        adjusted, needed = closed_tests(log_e, ALPHA / agents, least)
        return np.minimum(1.0, np.exp(-adjusted) * agents), needed

    e = least = _by_block([wealth(one, 0.0) for one in family], family)
    small = np.ones_like(e)
    if margin is not None:  # against a mean of the margin or more, and of minus the margin or less: the smaller
        both = [np.minimum(wealth(one, margin, "below"), wealth(one, -margin, "above")) for one in family]
        of_small = _by_block(both, family)
        least = np.minimum(e, of_small)
        small, _ = tested(of_small)
    p_values, needed = tested(e)
    return p_values, small, needed


def _by_block(processes: Sequence[Array], family: Sequence[Numbers]) -> Array:
    """The e-processes after each block, shape (blocks, means): 0 before the first number, as before where none is."""
    blocks = 1 + max((int(one.block[-1]) for one in family if len(one.block)), default=-1)
    found = np.zeros((blocks, len(family)))
    for i, (process, one) in enumerate(zip(processes, family, strict=True)):
        seen = np.searchsorted(one.block, np.arange(blocks), side="right")
        found[:, i] = np.concatenate([[0.0], process])[seen]
    return found


def _judged(one: Numbers, p_values: Array, limits: Array, small: Array) -> AtEveryLook:
    n = len(one.values)
    at = looks(n)
    seen = one.block[at - 1]
    lows, highs = confidence_sequence(one.values, limits[one.block], low=-one.bound, high=one.bound)
    return AtEveryLook(
        n=n,
        value=_mean(one.values),
        low=float(lows[-1]) if n else -one.bound,
        high=float(highs[-1]) if n else one.bound,
        p_value=float(p_values[seen].min(initial=1.0)),
        effect_at=_first(seen, p_values),
        small_p_value=float(small[seen].min(initial=1.0)),
        small_at=_first(seen, small),
        blocks=seen + 1,
        means=one.values.cumsum()[at - 1] / at,
        lows=lows,
        highs=highs,
        halves=(_mean(one.values[: n // 2]), _mean(one.values[n // 2 :])),
    )


def _mean(values: Array) -> float:
    return float(values.mean()) if len(values) else math.nan


def _first(seen: NDArray[np.int64], p_values: Array) -> int | None:
    """The number of the first block at which a P value is below 0.05."""
    found = seen[p_values[seen] < ALPHA]
    return int(found[0]) + 1 if len(found) else None


def closed_tests(log_e: Array, level: float, others: Array | None = None) -> tuple[Array, Array]:
    """The e-values adjusted for each other, and the e-value that each needs to be rejected, as logarithms.

    An adjusted one is the smallest mean of a set with the hypothesis. What it needs takes the place of 1 / level in the
    interval of one parameter among several: the interval then excludes the hypothesis if and only if closed testing
    rejects it, and it still covers its own parameter with 1 - level.

    Args:
        log_e: Logarithms of e-values at each look, shape (looks, hypotheses).
        level: Of the tests.
        others: The e-values that each hypothesis is judged beside, of the same shape; the same if None. Of several
            hypotheses of one parameter that exclude each other it is the smallest.

    >>> [np.exp(one).round(1).tolist() for one in closed_tests(np.log([[40.0, 10.0]]), 0.05)]
    [[[25.0, 10.0]], [[30.0, 20.0]]]
    """
    e, beside = (np.exp(np.minimum(one, _LARGEST)) for one in (log_e, log_e if others is None else others))
    adjusted, needed = np.empty((2, *log_e.shape))
    for i in range(e.shape[1]):
        sums = np.sort(np.delete(beside, i, axis=1), axis=1).cumsum(axis=1)  # of the 1, 2, … smallest others
        sums, sizes = np.pad(sums, ((0, 0), (1, 0))), np.arange(1, e.shape[1] + 1)
        adjusted[:, i] = np.log(((e[:, [i]] + sums) / sizes).min(axis=1))
        needed[:, i] = np.log((sizes / level - sums).max(axis=1))
    return adjusted, needed
