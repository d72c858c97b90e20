"""The state space of a box, and whether it can be played.

Configurations are numbers whose bit j is the position of joint j in panel order.
"""

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

    ``target`` is an index in panel order, ``start`` the initial configuration.

    Attributes:
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
    numbers, joints, target = np.arange(2 ** len(box.joints)), len(box.joints), box.target_index
    may_move = np.zeros((numbers.size, joints), bool)
    for j, name in enumerate(box.names):
        for clause in box.interlock.get(name, ({},)):
            may_move[:, j] |= holds(box, clause, numbers)
    start = sum(1 << j for j, position in enumerate(box.initial) if position)
    steps = np.full(numbers.size, -1)
    steps[start] = 0
    others = may_move.copy()
    others[:, target] = False
    front = np.array([start])
    while front.size:  # breadth first, one whole frontier at a time
        rows, moved = np.nonzero(others[front])
        after = front[rows] ^ (1 << moved)
        next_step = steps[front[0]] + 1
        steps[after[steps[after] < 0]] = next_step
        front = np.flatnonzero(steps == next_step)
    return Space(joints=joints, target=target, start=start, may_move=may_move, steps=steps)


def holds(box: Lockbox, clause: Clause, configurations: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Whether a clause holds entirely in each configuration; the same shape as ``configurations``."""
    bit = {name: 1 << j for j, name in enumerate(box.names)}
    named = sum(bit[other] for other in clause)
    found: NDArray[np.bool_] = (configurations & named) == sum(bit[o] for o, position in clause.items() if position)
    return found


def fault_of(box: Lockbox, shortest: int = 1) -> str | None:
    """Why a box cannot be played, in one line whose first words are the kind of the fault; None if it can be played.

    It is *unsolvable* if no sequence of attempts moves the target, *contradictory* if an alternative of the target
    holds in no reachable configuration, *too short* if the optimum has fewer than ``shortest`` steps.
    """
    space = space_of(box)
    if not space.may_move[space.start].any():
        return "unsolvable: nothing moves, every joint is locked at the start"
    if space.optimum is None:
        return f"unsolvable: no sequence of attempts moves {box.target}"
    for clause in box.interlock.get(box.target, ()):
        if not holds(box, clause, space.reachable).any():
            words = ", ".join(f"{other} = {int(position)}" for other, position in clause.items())
            return f"contradictory: {{{words}}} of target {box.target} holds in no configuration that can be reached"
    if space.optimum < shortest:
        return f"too short: solved in {space.optimum} of at least {shortest} steps"
    return None


@cache
def orders(joints: int) -> NDArray[np.int64]:
    """Every order of this many joints, shape (joints!, joints)."""
    return np.array(list(permutations(range(joints))))
