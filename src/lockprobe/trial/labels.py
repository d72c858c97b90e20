"""The labels of joints and the order in which they are listed, drawn for a trial or a study."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.box import Configuration, Lockbox, Shuffle, bits
from lockprobe.boxes.layouts import locking_pairs, neutral_order
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.seeds import generator
from lockprobe.trial.luck import Luck
from lockprobe.trial.pictures.frame import Frame
from lockprobe.trial.record import Percept, Snapshot, Task

LABELS = "ABCDEFGH"
"""Neutral labels; a box has at most this many joints."""


def drawn_orders(numbers: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Of each joint in panel order the number of its label, and for each list position a joint, shape (..., joints).

    ``numbers`` are two for each joint from the stream of labels, shape (..., 2 * joints).
    """
    joints = numbers.shape[-1] // 2
    return numbers[..., :joints].argsort(), numbers[..., joints:].argsort()


@lru_cache(maxsize=64)
def orders_of_study(
    locking: frozenset[tuple[int, int]], joints: int, seed: int
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """The same, drawn once for a whole study: neither labels nor their list follow the interlock.

    Among joints of successive labels, and among neighbours in the list, as many lock each other as on average over all
    orders (:func:`lockprobe.boxes.layouts.neutral_order`). ``locking`` are the pairs that do
    (:func:`lockprobe.boxes.layouts.locking_pairs`).
    """
    rng, row = generator(seed, "study", "labels"), [(i, i + 1) for i in range(joints - 1)]
    labelled, listed = (neutral_order(locking, row, joints, rng) for _ in range(2))
    return tuple(labelled.index(joint) for joint in range(joints)), tuple(listed)


_UNSEEN = Percept()


class Names:
    """Translates between the agent's labels and listing and the box's joints in panel order.

    Attributes:
        labels: For each joint in panel order its label.
        order: For each list position a joint, by index in panel order.
        listing: The labels as they are listed to the agent.
        task: The agent's knowledge before it begins.
    """

    def __init__(self, box: Lockbox, *, shuffle: Shuffle, seed: int, luck: Luck, budget: int, assessment: bool) -> None:
        joints = box.joints
        if shuffle == "study":
            dealt, self.order = orders_of_study(frozenset(locking_pairs(box)), len(joints), seed)
        elif shuffle == "trial":
            drawn = drawn_orders(luck.at("labels").random(2 * len(joints)))
            dealt, self.order = (tuple(order.tolist()) for order in drawn)
        else:
            dealt = self.order = tuple(range(len(joints)))
        self.labels = tuple([LABELS[i] for i in dealt])
        self.listing = tuple([self.labels[i] for i in self.order])
        self._listed = tuple([self.listing.index(label) for label in self.labels])
        self.task = Task(
            joints=self.listing,
            target=self.labels[box.target_index],
            budget=budget,
            places=tuple([joints[i].place for i in self.order]),
            kinds=tuple([joints[i].kind for i in self.order]),
            assessment=assessment,
        )

    def percept(self, snapshot: Snapshot) -> Percept:
        """The truth in the agent's terms, without a way to look."""
        return _UNSEEN.but(
            joint=None if snapshot.joint is None else self.labels[snapshot.joint],
            outcome=snapshot.outcome,
            positions=tuple(snapshot.configuration[joint] for joint in self.order),
        )

    def picture(self, snapshot: Snapshot, positions: tuple[bool, ...] | None = None) -> Frame:
        """The current picture, or one of told positions; handles in the order of the listing."""
        told = snapshot.configuration if positions is None else self.configuration(positions)
        if told == snapshot.configuration:
            assert snapshot.look is not None
            frame = snapshot.look()
        elif snapshot.render is None:
            raise BadValue("false picture", bits(told), "a plant that can draw false pictures: fast-twin or twin")
        else:
            frame = snapshot.render(told)
        return replace(frame, handles=frame.handles[list(self.order)])

    def configuration(self, positions: tuple[bool, ...]) -> Configuration:
        """Positions of the joints as listed, in panel order."""
        return tuple(positions[place] for place in self._listed)
