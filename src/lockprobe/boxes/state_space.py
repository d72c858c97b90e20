"""The state space of a box. Configurations are numbers whose bit j is the position of joint j in panel order."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.box import Clause, Lockbox


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Space:
    """Possible moves in every configuration, and the configurations reachable before the target moves.

    A clause names other joints only, so every move can be undone at once, and all reachable configurations can be
    reached from each other.

    Attributes:
        joints: Number of joints n.
        target: Index of the target in panel order.
        start: The initial configuration.
        may_move: Whether the interlock lets a joint move in a configuration, shape (2**n, n).
        steps: The fewest moves from the start to a configuration without the target, shape (2**n,); -1 if it cannot be
            reached.
    """

    joints: int
    target: int
    start: int
    may_move: NDArray[np.bool_]
    steps: NDArray[np.int64]

    @property
    def reachable(self) -> NDArray[np.int64]:
        """The reachable configurations, nearest first."""
        found = np.flatnonzero(self.steps >= 0)
        return found[np.argsort(self.steps[found], kind="stable")]

    @property
    def last(self) -> NDArray[np.int64]:
        """The configurations from which optimal plans move the target; none for an unsolvable box."""
        ends = np.flatnonzero((self.steps >= 0) & self.may_move[:, self.target])
        return ends[self.steps[ends] == self.steps[ends].min()] if ends.size else ends

    @property
    def optimum(self) -> int | None:
        """The fewest steps that move the target; None for an unsolvable box."""
        return int(self.steps[self.last[0]]) + 1 if self.last.size else None


def space_of(box: Lockbox) -> Space:
    """All configurations of a box."""
    numbers = np.arange(2 ** len(box.joints))
    may_move = np.zeros((numbers.size, len(box.joints)), bool)
    for j, name in enumerate(box.names):
        for clause in box.interlock.get(name, ({},)):
            may_move[:, j] |= holds(box, clause, numbers)
    start = sum(1 << j for j, position in enumerate(box.initial) if position)
    return Space(
        joints=len(box.joints),
        target=box.target_index,
        start=start,
        may_move=may_move,
        steps=_steps(start, may_move, box.target_index),
    )


def holds(box: Lockbox, clause: Clause, configurations: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Whether a clause holds entirely in each configuration; the same shape as ``configurations``."""
    bit = {name: 1 << j for j, name in enumerate(box.names)}
    named = sum(bit[other] for other in clause)
    found: NDArray[np.bool_] = (configurations & named) == sum(bit[o] for o, position in clause.items() if position)
    return found


@cache
def orders(joints: int) -> NDArray[np.int64]:
    """Every order of this many joints, shape (joints!, joints)."""
    return np.array(list(permutations(range(joints))))


def _steps(start: int, may_move: NDArray[np.bool_], target: int) -> NDArray[np.int64]:
    """Distances by breadth-first search, one whole frontier at a time."""
    steps = np.full(len(may_move), -1)
    steps[start] = 0
    others = may_move.copy()
    others[:, target] = False
    front = np.array([start])
    while front.size:
        rows, joints = np.nonzero(others[front])
        after = front[rows] ^ (1 << joints)
        fresh, next_step = after[steps[after] < 0], steps[front[0]] + 1
        steps[fresh] = next_step
        front = np.flatnonzero(steps == next_step)
    return steps
