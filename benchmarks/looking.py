"""Statements at every look on many simulated studies at once; ``every_look.py`` uses it.

The wealth of a bet on paired differences depends on how many pairs fell either way, so that studies of one world are
judged together as arrays. :func:`same_as_the_report` holds them to what a report computes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.proportions import ALPHA
from lockprobe.statistics.sequential.betting import DIFFERENCES, NEAR, looks
from lockprobe.statistics.sequential.closed import adjusted
from lockprobe.statistics.sequential.contrasts import Numbers, at_every_look

Array = NDArray[np.float64]
Whole = NDArray[np.int64]

NEVER = 10**9
"""The block of what is never said."""

_ROWS = 20_000
"""Rows of counts whose wealth is computed at once."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Said:
    """What is said of each dose of each study at each look.

    Attributes:
        effect: 1 or -1 for the direction in which an effect is said, 0 where none is, shape (studies, looks, doses).
        small: Whether it is said that success changes by less than the margin, of the same shape.
        blocks: Blocks at each look, shape (looks,).
    """

    effect: NDArray[np.int8]
    small: NDArray[np.bool_]
    blocks: Whole

    def first(self, which: NDArray[np.bool_]) -> Whole:
        """The block at which something is said first, :data:`NEVER` if it is not; shape (studies, doses)."""
        found: Whole = np.where(which.any(axis=1), self.blocks[which.argmax(axis=1)], NEVER)
        return found


def said_at_every_look(pairs: NDArray[np.int8], *, agents: float = 1, margin: float | None = None) -> Said:
    """What is said of paired differences.

    Args:
        pairs: 1, 0 or -1 for each block, shape (studies, blocks, doses); every block has a pair.
        agents: Agents that are judged together.
        margin: As in :func:`lockprobe.statistics.sequential.contrasts.at_every_look`.
    """
    blocks = pairs.shape[1]
    at = looks(blocks)
    fell = np.stack([(pairs == kind).cumsum(axis=1, dtype=np.int32)[:, at - 1] for kind in (-1, 0, 1)], axis=-1)
    wealth, limit = _wealth(fell, 0.0), math.log(agents / ALPHA)
    small, least = np.zeros(wealth.shape, dtype=np.bool_), wealth
    if margin is not None:
        of_small = np.minimum(_wealth(fell, margin, "below"), _wealth(fell, -margin, "above"))
        least = np.minimum(wealth, of_small)
        small = _ever(of_small, least) > limit
    effect = np.where(_ever(wealth, least) > limit, np.sign(fell[..., 2] - fell[..., 0]), 0).astype(np.int8)
    return Said(effect=effect, small=small, blocks=at)


def _ever(wealth: Array, beside: Array) -> Array:
    """The largest wealth so far, adjusted for that of the other doses; shape (studies, looks, doses)."""
    doses = wealth.shape[-1]
    found = adjusted(wealth.reshape(-1, doses), beside.reshape(-1, doses)).reshape(wealth.shape)
    most: Array = np.maximum.accumulate(found, axis=1)
    return most


def _wealth(fell: NDArray[np.int32], mean: float, side: str = "both") -> Array:
    """The logarithm of the wealth against a mean; counts of -1, 0 and 1 on the last axis."""
    at = (mean + 1) / 2
    bets = {"both": DIFFERENCES, "below": at * NEAR, "above": 1 - (1 - at) * NEAR}[side]
    gains = np.array([np.log((1 - x) * (1 - bets) / (1 - at) + x * bets / at) for x in (0.0, 0.5, 1.0)])
    rows = fell.reshape(-1, 3) * (1, at != 0.5, 1)  # against 0, pairs that do not differ change nothing
    code, place = np.unique(rows @ (1 << np.array([0, 20, 40])), return_inverse=True)
    rows = np.stack([code >> shift & (1 << 20) - 1 for shift in (0, 20, 40)], axis=1)
    found = np.empty(len(rows))
    for start in range(0, len(rows), _ROWS):
        logarithms = rows[start : start + _ROWS] @ gains
        largest = logarithms.max(axis=1)
        logarithms -= largest[:, None]
        found[start : start + _ROWS] = np.log(np.exp(logarithms, out=logarithms).mean(axis=1)) + largest
    return found[place.reshape(-1)].reshape(fell.shape[:-1])


def same_as_the_report(pairs: NDArray[np.int8], said: Said, *, agents: float = 1, margin: float | None = None) -> None:
    """Hold what was said of the first study to what a report computes from its trials."""
    blocks = np.arange(pairs.shape[1])
    family = [Numbers(values=one.astype(np.float64), block=blocks) for one in pairs[0].T]
    judged = at_every_look(family, agents=agents, margin=margin)
    effects, smalls = said.first(said.effect != 0)[0], said.first(said.small)[0]
    for i, one in enumerate(judged):
        assert (one.effect_at or NEVER) == effects[i], (one.effect_at, effects[i])
        assert (one.small_at or NEVER) == smalls[i], (one.small_at, smalls[i])
        assert (one.low > 0 or one.high < 0) == (one.effect_at is not None)
