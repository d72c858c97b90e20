"""Batches of random boxes for training and testing learners: their rules, and the best next joints in each state.

Each box has a random order of its joints. Each joint except the first needs at most one earlier joint, open or closed.
The target is the last one. All joints are closed at the start, and the target is then locked.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.state_space import space_of

__all__ = ["Boxes", "copies", "random_boxes"]

LOCKED, BEFORE, OPEN = 0.85, 0.5, 0.8
"""Chance that a joint needs another; that this is the one before it and not any earlier one; that it has to be open."""

_FAR = 10_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Boxes:
    """A batch of boxes of n joints. States are numbers; bit j says that joint j is away from its start.

    Attributes:
        may_move: Whether a joint may move in a state, shape (boxes, 2^n, n).
        distance: Fewest steps to open the box from a state, shape (boxes, 2^n).
        target: The target, shape (boxes,).
    """

    may_move: NDArray[np.bool_]
    distance: NDArray[np.int64]
    target: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.target)

    @property
    def joints(self) -> int:
        """Joints of each box."""
        return int(self.may_move.shape[2])

    def moves(self, state: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Whether each joint may move in the state of each box, shape (boxes, n)."""
        return self.may_move[np.arange(len(self)), state]

    def best(self, state: NDArray[np.int64]) -> NDArray[np.bool_]:
        """The joints that open each box in the fewest steps from its state, shape (boxes, n)."""
        every = np.arange(len(self))
        after = self.distance[every[:, None], state[:, None] ^ (1 << np.arange(self.joints))]
        after[every, self.target] = 0
        found: NDArray[np.bool_] = self.moves(state) & (after + 1 == self.distance[every, state][:, None])
        return found


def random_boxes(number: int, joints: int, rng: np.random.Generator) -> Boxes:
    """A batch of random boxes, all with this number of joints."""
    order = np.argsort(rng.random((number, joints)), axis=1)
    earlier = np.where(
        rng.random((number, joints)) < BEFORE,
        np.arange(joints) - 1,
        (rng.random((number, joints)) * np.arange(joints)).astype(np.int64),
    )
    needs, is_open = rng.random((number, joints)) < LOCKED, rng.random((number, joints)) < OPEN
    needs[:, 0], needs[:, -1], is_open[:, -1] = False, True, True
    every = np.arange(number)[:, None]
    parent, free, wanted = (np.empty((number, joints), dtype=np.int64) for _ in range(3))
    parent[every, order] = order[every, np.maximum(earlier, 0)]
    free[every, order], wanted[every, order] = ~needs, is_open
    states = np.arange(1 << joints)[None, :, None]
    may_move = (free[:, None, :] == 1) | ((states >> parent[:, None, :]) & 1 == wanted[:, None, :])
    target = order[:, -1]
    return Boxes(may_move=may_move, distance=_distance(may_move, target), target=target)


def copies(box: Lockbox, number: int, rng: np.random.Generator) -> Boxes:
    """A batch of copies of one box, each with its joints in a random order."""
    space = space_of(box)
    joints = len(box.names)
    dealt = np.argsort(rng.random((number, joints)), axis=1)  # joint of the box -> joint of the copy
    bits = (np.arange(1 << joints)[None, :, None] >> dealt[:, None, :]) & 1
    own = space.start ^ np.asarray((bits << np.arange(joints)).sum(axis=2))
    may_move = np.empty((number, 1 << joints, joints), dtype=np.bool_)
    np.put_along_axis(may_move, np.broadcast_to(dealt[:, None, :], may_move.shape), space.may_move[own], axis=2)
    target = dealt[:, box.target_index]
    return Boxes(may_move=may_move, distance=_distance(may_move, target), target=target)


def _distance(may_move: NDArray[np.bool_], target: NDArray[np.int64]) -> NDArray[np.int64]:
    """Fewest steps to the solution from every state, by value iteration."""
    number, states, joints = may_move.shape
    opens = np.take_along_axis(may_move, np.broadcast_to(target[:, None, None], (number, states, 1)), axis=2)[:, :, 0]
    distance = np.where(opens, 1, _FAR)
    while True:
        nearer = distance.copy()
        for joint in range(joints):
            ahead = distance[:, np.arange(states) ^ (1 << joint)] + 1
            np.minimum(nearer, np.where(may_move[:, :, joint], ahead, _FAR), out=nearer)
        if np.array_equal(nearer, distance):
            return distance
        distance = nearer
