"""E-processes and confidence sequences of the mean of bounded numbers, by betting.

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
22.2 in place of 23.1 if 80 % do, and after 7 as before if all do. One-sided bets are for small differences, so they lie
closer to the mean of the hypothesis, by the quantiles of Beta(3/2, 1).
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

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

_AT_ONCE = 1 << 15
"""Numbers that are computed at once: as many as a processor has at hand."""

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
    """The logarithm of the e-process against a mean, after each number; if it holds, ever log(20) in 1 of 20 at most.

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
    inside, outside = middle.copy(), np.full(len(middle), extreme)
    is_open = _wealth_at(kinds, seen, outside, bets) < limit
    for _ in range(_HALVINGS):
        half = (inside + outside) / 2
        kept = _wealth_at(kinds, seen, half, bets) < limit
        inside, outside = np.where(kept, half, inside), np.where(kept, outside, half)
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


def _wealth_at(kinds: Array, seen: Array, mean: Array, bets: Array) -> Array:
    """The logarithm of the wealth at each look, against another mean at each, shape (looks,)."""
    found, at_once = np.empty(len(mean)), max(1, _AT_ONCE // (len(kinds) * len(bets)))
    for i in range(0, len(mean), at_once):
        part = slice(i, i + at_once)
        found[part] = _mean_of_exp(np.einsum("lk,lkb->lb", seen[part], _gains(kinds, mean[part], bets)))
    return found


def _mean_of_exp(logarithms: Array) -> Array:
    """The logarithm of the mean over the last axis of their exponentials."""
    largest = logarithms.max(axis=-1, keepdims=True)
    found: Array = np.log(np.exp(logarithms - largest).mean(axis=-1)) + largest[..., 0]
    return found
