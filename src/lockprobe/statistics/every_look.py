"""What holds at every look: e-processes and confidence sequences by betting, and several means judged together.

A P value and a 95 % interval hold for one look at a number of trials that was fixed before. An *e-process* starts at 1
and, if the hypothesis holds, exceeds 20 at *any* look with a probability of at most 1 / 20 (Ville 1939). So 1 over its
maximum is a P value, and the means that it does not exceed 20 for are a 95 % interval, however often one looks.

Here it is the wealth of somebody who bets against the mean m of numbers scaled to [0, 1]. A bet on theta multiplies the
wealth by x theta / m + (1 - x) (1 - theta) / (1 - m) for each number x; the wealth is averaged over 128 bets that are
fixed before. Of solved and unsolved trials that is a mixture of binomial likelihood ratios (Robbins 1970), of paired
differences at m = 1/2 that of the pairs that differ, and of any other bounded numbers the betting of Waudby-Smith and
Ramdas (JRSS B 2024, Sec. 4). The numbers may depend on each other as long as each has the mean m given those before it.

Any fixed bets give a valid test, and which ones decides how soon it rejects. Those of Beta(1/2, 1/2) have the narrowest
intervals of shares near 0 and 1. Differences are seldom so large: halfway between their quantiles and those of the
uniform distribution, a test of pairs rejects after 249 pairs that differ in place of 260 if 60 % of them fall one way,
and after 7 as before if all do. One-sided bets are for small differences, so they lie closer to the mean of the
hypothesis, by the quantiles of Beta(3/2, 1).

Each mean is tested for an effect (it is not 0) and, with a margin, for being small (it lies within the margin). All of
these statements are one family, corrected by closed testing: a mean cannot be 0 and as large as the margin, so that of
each mean one of the two hypotheses counts, that with less evidence against it. A hypothesis is rejected if every set of
hypotheses that it is in has a mean e-value of 20 or more (Vovk and Wang, Annals of Statistics 2021, Sec. 6), however
they depend on each other. One that is true is then rejected in at most 5 % of studies, at any look. Once a statement is
made it stays: P values are the smallest of all looks, and intervals lie within those before.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lockprobe.statistics.broken_trials import bounded
from lockprobe.statistics.proportions import ALPHA, Proportion, between

Array = NDArray[np.float64]

_PARTS = (np.arange(128) + 0.5) / 128

SHARES = np.sin(_PARTS * np.pi / 2) ** 2
"""Bets between 0 and 1 with equal weights, for intervals of shares."""

DIFFERENCES = (_PARTS + SHARES) / 2
"""The same for differences."""

NEAR = _PARTS ** (2 / 3)
"""Bets of one side as shares of the way from the end of the range, 0, to the mean of the hypothesis, 1."""

_HALVINGS = 18
"""Steps of bisection to an end of an interval; it is then known to 4e-6 of the range, and not narrower than it is."""

_EDGE = 1e-9

_EVERY = 100
_GROWTH = 1.01
"""Looks are taken after each of the first 100 numbers, and then whenever there are 1 % more of them."""

Side = Literal["both", "below", "above"]
"""Which means speak against the hypothesis: any other one, those below, or those above."""


def looks(numbers: int) -> NDArray[np.int64]:
    """After how many numbers there is a look. It does not depend on how many there will be.

    Looking less often than one could is valid, and only makes intervals wider.

    >>> looks(3).tolist(), looks(105)[-2:].tolist()
    ([1, 2, 3], [104, 105])
    """
    if numbers <= _EVERY:
        return np.arange(1, numbers + 1)
    more = np.arange(1, math.log(numbers / _EVERY) / math.log(_GROWTH) + 1)
    later = np.unique(np.ceil(_EVERY * _GROWTH**more)).astype(np.int64)
    return np.concatenate([np.arange(1, _EVERY + 1), later[later <= numbers]])


def log_wealth(values: ArrayLike, mean: float, *, low: float = 0.0, high: float = 1.0, side: Side = "both") -> Array:
    """The logarithm of the e-process against a mean, after each number; a true one ever meets log(20) 1 time in 20.

    Args:
        values: The numbers in the order in which they were drawn, each in [low, high], shape (numbers,).
        mean: The mean of the hypothesis, in (low, high). With ``side="below"`` it is that the mean is at least this
            one, with ``side="above"`` that it is at most this one.
        low: Lower bound of the numbers, known before.
        high: Upper bound.
        side: On which side of the hypothesis means speak against it.

    >>> round(float(log_wealth([1] * 6, 0.0, low=-1, high=1)[-1]), 2)
    2.44
    """
    kinds, counts = _counted(values, low, high)
    at = (mean - low) / (high - low)
    bets = {"both": DIFFERENCES, "below": at * NEAR, "above": 1 - (1 - at) * NEAR}[side]
    return _mean_of_exp(counts.cumsum(axis=0) @ _gains(kinds, np.full(1, at), bets)[0])


def confidence_sequence(
    values: ArrayLike,
    log_threshold: ArrayLike,
    *,
    low: float = 0.0,
    high: float = 1.0,
    bets: Array = DIFFERENCES,
) -> tuple[Array, Array]:
    """The ends of the interval of the mean at each of :func:`looks`, each within all before it.

    An interval that would leave nothing of those before it is left out, which happens with a probability of at most 1
    over the threshold.

    Args:
        values: The numbers in the order in which they were drawn, each in [low, high], shape (numbers,).
        log_threshold: Logarithm of the e-value that excludes a mean, after each number or at once for all; log(20) for
            an interval of 95 %.
        low: Lower bound of the numbers, known before.
        high: Upper bound.
        bets: Bets between 0 and 1, shape (bets,); those of :func:`log_wealth` unless they are for shares.

    >>> ends = confidence_sequence([1, 0] * 50, math.log(20))
    >>> round(float(ends[0][-1]), 2), round(float(ends[1][-1]), 2)
    (0.35, 0.66)
    """
    kinds, counts = _counted(values, low, high)
    at = looks(len(counts))
    if not len(at):
        return np.empty(0), np.empty(0)
    seen, limit = counts.cumsum(axis=0)[at - 1], np.broadcast_to(np.asarray(log_threshold, float), len(counts))[at - 1]
    middle = np.clip(seen @ kinds / seen.sum(axis=1), _EDGE, 1 - _EDGE)
    lower, upper = (_end(kinds, seen, limit, bets, middle, extreme) for extreme in (_EDGE, 1 - _EDGE))
    ends = -np.inf, np.inf
    for i in range(len(at)):
        first, second = max(ends[0], lower[i]), min(ends[1], upper[i])
        ends = (first, second) if first < second else ends
        lower[i], upper[i] = ends
    return low + (high - low) * lower, low + (high - low) * upper


def _end(kinds: Array, seen: Array, limit: Array, bets: Array, middle: Array, extreme: float) -> Array:
    """One end of the interval at each look, on the scale from 0 to 1, by bisection.

    Args:
        kinds: The different numbers, shape (kinds,).
        seen: How often each was drawn by each look, shape (looks, kinds).
        limit: Logarithm of the e-value that excludes a mean, shape (looks,).
        bets: Bets between 0 and 1.
        middle: The mean at each look, shape (looks,).
        extreme: The end of the range, which the interval has where not even that is excluded.
    """

    def kept(means: Array) -> NDArray[np.bool_]:
        found: NDArray[np.bool_] = _mean_of_exp(np.einsum("lk,lkb->lb", seen, _gains(kinds, means, bets))) < limit
        return found

    inside, outside = middle.copy(), np.full(len(middle), extreme)
    is_open = kept(outside)
    for _ in range(_HALVINGS):
        half = (inside + outside) / 2
        there = kept(half)
        inside, outside = np.where(there, half, inside), np.where(there, outside, half)
    return np.where(is_open, round(extreme), outside)


def _counted(values: ArrayLike, low: float, high: float) -> tuple[Array, Array]:
    """The different numbers on the scale from 0 to 1, and for each number a row with a one in the column of its own."""
    kinds, place = np.unique(np.asarray(values, dtype=np.float64), return_inverse=True)
    if len(kinds) and not low <= kinds[0] <= kinds[-1] <= high:
        raise ValueError(f"numbers from {kinds[0]:g} to {kinds[-1]:g}, not within {low:g} and {high:g}")
    return (kinds - low) / (high - low), np.eye(len(kinds))[place]


def _gains(kinds: Array, mean: Array, bets: Array) -> Array:
    """What each number multiplies the wealth by, as a logarithm: shape (means, numbers, bets)."""
    at, x = mean[:, None, None], kinds[:, None]
    gains: Array = np.log(x * bets / at + (1 - x) * (1 - bets) / (1 - at))
    return gains


def _mean_of_exp(logarithms: Array) -> Array:
    """The logarithm of the mean over the last axis of their exponentials."""
    largest = logarithms.max(axis=-1, keepdims=True)
    found: Array = np.log(np.exp(logarithms - largest).mean(axis=-1)) + largest[..., 0]
    return found


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
        small_at: Number of the block at which the P value of "the mean is as large as the margin or larger, either way"
            fell below 0.05; None if at none, and without a margin.
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

    def wealth(one: Numbers, mean: float, side: Side = "both") -> Array:
        return log_wealth(one.values, mean, low=-one.bound, high=one.bound, side=side)

    def p_values(adjusted: Array) -> Array:
        return np.minimum(1.0, np.exp(-adjusted) * agents)

    effects = least = _by_block([wealth(one, 0.0) for one in family], family)
    small = np.ones_like(effects)
    if margin is not None:  # against a mean of the margin or more, and of minus the margin or less: the smaller
        both = [np.minimum(wealth(one, margin, "below"), wealth(one, -margin, "above")) for one in family]
        smalls = _by_block(both, family)
        least = np.minimum(effects, smalls)
        small = p_values(closed_tests(smalls, ALPHA / agents, least)[0])
    adjusted, limits = closed_tests(effects, ALPHA / agents, least)
    tested = zip(family, p_values(adjusted).T, limits.T, small.T, strict=True)
    return tuple(_judged(*one) for one in tested)


def held_at_both_ends(found: AtEveryLook, low: AtEveryLook, high: AtEveryLook) -> AtEveryLook:
    """A course without the broken trials, with what holds at both ends of what these can have become.

    The ends have a number for every begun block; the course runs over these, through the middle of both means.
    """
    effects, smalls = ([getattr(one, name) for one in (low, high)] for name in ("effect_at", "small_at"))
    return replace(
        bounded(found, low, high),
        effect_at=max(effects) if None not in effects and low.value * high.value > 0 else None,
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
    if (unknown := np.isnan(values)).any():
        none, every = (share_at_every_look(np.where(unknown, end, values)) for end in (0.0, 1.0))
        return between(share_at_every_look(values[~unknown]), none, every)
    lows, highs = confidence_sequence(values, math.log(1 / ALPHA), bets=SHARES)
    low, high = (float(lows[-1]), float(highs[-1])) if len(values) else (0.0, 1.0)
    return Proportion(count=int(values.sum()), n=len(values), value=_mean(values), low=low, high=high)


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
