"""The plan of one trial, and the names of its joints for the agent."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial

import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.box import Configuration, Lockbox, Shuffle, bits
from lockprobe.boxes.layouts import locking_pairs, neutral_order
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.seeds import generator
from lockprobe.foundation.spec import group_of
from lockprobe.trial.condition import Condition
from lockprobe.trial.luck import Luck
from lockprobe.trial.pictures.frame import Frame
from lockprobe.trial.protocols import Intervention
from lockprobe.trial.record import Ask, ForkName, Percept, Snapshot, Step, Task, TrialName

LABELS = "ABCDEFGH"
"""Neutral labels; a box has at most this many joints."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Fork:
    """A fork of a recorded trial: one report, or the next action, is changed, and the agent plays on.

    Up to the report of step ``at`` the trial is the one on record. What its condition tells is replaced in that report
    by the truth, on which the arm acts.

    ``condition`` is the label of that of the forked trial, ``acting`` the intervention of the arm on the report, or on
    the action after it, and ``recorded`` are the recorded steps.
    """

    name: ForkName
    condition: str
    acting: tuple[Intervention, ...]
    recorded: tuple[Step, ...]

    def replaces(self, step: int) -> bool:
        """Whether the arm acts on the true report of this step, from 1, whatever the condition tells."""
        return step == self.name.at or (self.name.truthful and step > self.name.at)


@dataclass(frozen=True, kw_only=True)
class Plan:
    """The plan of one trial, which has a number and a repetition from 1.

    Attributes:
        agent: Agent spec; ``called`` is the name that the experimenter gave it, empty without one.
        seed: Seed of the study.
        budget: Steps; 20 in the paper.
        plant: The plant's spec.
        shuffle: How often labels are assigned to joints, and listed, in random order. With ``never`` the labels run
            along the panel, and a model's preference for a name or a list position is confounded with the box.
        assessment: Whether the agent is asked what its last action did.
        hypothesis: When the agent is asked how the box works, unless an intervention says otherwise.
        fork: The fork of a recorded trial; None for an ordinary trial.
    """

    study: str
    agent: str
    box: Lockbox
    condition: Condition
    repetition: int
    trial: int
    seed: int
    budget: int = 20
    plant: str = "symbolic"
    shuffle: Shuffle = "trial"
    assessment: bool = True
    hypothesis: Ask = "before"
    fork: Fork | None = None
    called: str = ""

    @cached_property
    def key(self) -> str:
        """The readable name of its record."""
        return str(self.name if self.fork is None else self.fork.name)

    @property
    def group(self) -> str:
        """What keys call its agent, as :attr:`lockprobe.trial.record.Trial.group`."""
        return self.called or group_of(self.agent)

    @property
    def name(self) -> TrialName:
        """Its place in the study; of a fork that of its parent."""
        return TrialName(self.study, self.group, self.label, self.repetition, self.trial)

    @property
    def label(self) -> str:
        """The label of its condition; of a fork that of its parent, to which the arm adds."""
        return self.condition.label if self.fork is None else self.fork.condition

    @property
    def modality(self) -> str:
        """How the box is shown."""
        return self.condition.modality

    @cached_property
    def luck(self) -> Luck:
        """The luck of the trial. It depends on seed, box, repetition and trial, not on the condition."""
        return Luck(seed=self.seed, box=self.box.name, repetition=self.repetition, trial=self.trial)

    @cached_property
    def names(self) -> Names:
        """The names of its joints for the agent."""
        return Names(self)


def drawn_orders(numbers: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Of each joint in panel order the number of its label, and for each list position a joint, shape (..., joints).

    ``numbers`` are two for each joint from the stream of labels, shape (..., 2 * joints).
    """
    joints = numbers.shape[-1] // 2
    return np.argsort(numbers[..., :joints]), np.argsort(numbers[..., joints:])


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

    def __init__(self, plan: Plan) -> None:
        joints = plan.box.joints
        if plan.shuffle == "study":
            dealt, self.order = orders_of_study(frozenset(locking_pairs(plan.box)), len(joints), plan.seed)
        elif plan.shuffle == "trial":
            drawn = drawn_orders(plan.luck.at("labels").random(2 * len(joints)))
            dealt, self.order = (tuple(order.tolist()) for order in drawn)
        else:
            dealt = self.order = tuple(range(len(joints)))
        self.labels = tuple([LABELS[i] for i in dealt])
        self.listing = tuple([self.labels[i] for i in self.order])
        self._listed = tuple([self.listing.index(label) for label in self.labels])
        self.task = Task(
            joints=self.listing,
            target=self.labels[plan.box.target_index],
            budget=plan.budget,
            places=tuple([joints[i].place for i in self.order]),
            kinds=tuple([joints[i].kind for i in self.order]),
            assessment=plan.assessment,
        )

    def percept(self, snapshot: Snapshot) -> Percept:
        """The truth in the agent's terms."""
        return _UNSEEN.but(
            joint=None if snapshot.joint is None else self.labels[snapshot.joint],
            outcome=snapshot.outcome,
            positions=tuple(map(snapshot.configuration.__getitem__, self.order)),
            look=None if snapshot.look is None else partial(self._seen, snapshot),
        )

    def _seen(self, snapshot: Snapshot, positions: tuple[bool, ...] | None = None) -> Frame:
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
        return tuple(map(positions.__getitem__, self._listed))
