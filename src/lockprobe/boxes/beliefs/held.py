"""What several beliefs hold possible, as the rows of arrays: a call of NumPy takes longer than the numbers of one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise

import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.beliefs.posterior import OF_OUTCOMES, Belief

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Held:
    """The interlocks that are possible under each of several beliefs, one after the other.

    Attributes:
        joints: Number of joints n.
        beliefs: Number of beliefs.
        belief: Whose each row is, ascending, shape (rows,).
        possible: Whether each reading is possible, shape (kinds, rows).
        weights: Posterior probability, shape (rows,).
        moves: Whether each joint may move, shape (rows, n).
        false: Probability that the next report is false, shape (rows, 1).
        configuration: The configuration, shape (rows, 1).
        compared: The configuration from which the next report says that a joint moved or not, shape (rows, 1).
        positions: The configuration as told last, shape (rows, 1); 0 where positions are not told.
        shown: Whether they are told, shape (rows, 1).
        states_only: Whether the last report told positions and no outcome, shape (rows, 1).
    """

    joints: int
    beliefs: int
    belief: NDArray[np.int64]
    possible: NDArray[np.bool_]
    weights: Floats
    moves: NDArray[np.bool_]
    false: Floats
    configuration: NDArray[np.int64]
    compared: NDArray[np.int64]
    positions: NDArray[np.int64]
    shown: NDArray[np.bool_]
    states_only: NDArray[np.bool_]

    def sums(self, values: Floats) -> Floats:
        """Sums over the rows of each belief, shape (beliefs,)."""
        ends = accumulate(np.bincount(self.belief, minlength=self.beliefs).tolist(), initial=0)
        return np.array([values[a:b].sum() for a, b in pairwise(ends)])


def held_by(beliefs: Sequence[Belief]) -> Held:
    """The rows of beliefs under one prior and one model of reports."""
    known, noise = beliefs[0].interlocks, beliefs[0].noise
    possible = np.concatenate([belief.possible for belief in beliefs], axis=1)
    held = possible.any(axis=0)
    belief = np.arange(len(beliefs)).repeat(len(known))[held]
    configuration = np.concatenate([belief.configuration for belief in beliefs])[held, None]
    told = np.array([belief.told for belief in beliefs])[belief, None]
    false = np.concatenate([belief.false for belief in beliefs])[held, None]
    positions = np.array([belief.positions or 0 for belief in beliefs])[belief, None]
    shown = np.array([belief.positions is not None for belief in beliefs])[belief, None]
    return Held(
        joints=known.joints,
        beliefs=len(beliefs),
        belief=belief,
        possible=possible[:, held],
        weights=np.concatenate([belief.weights for belief in beliefs])[held],
        moves=np.concatenate([known.may_move(belief.configuration) for belief in beliefs])[held],
        false=(false + 1) / (told + 2) if noise.p is None else np.full(false.shape, noise.p),
        configuration=configuration,
        compared=np.where(shown, positions, configuration) if noise.kinds[0] in OF_OUTCOMES else configuration,
        positions=positions,
        shown=shown,
        states_only=np.array([belief.states_only for belief in beliefs])[belief, None],
    )
