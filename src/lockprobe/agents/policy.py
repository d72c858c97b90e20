"""Policies: agents whose whole memory is one small value.

A policy begins with a memory, updates it with every report, and derives a probability for each joint. The memory is a
hashable value, so the same policy can be played here step by step, propagated exactly or sampled by the thousand
(:mod:`lockprobe.simulation.kernel`), and fitted (``examples/fit_policy.py``). Joints are indices into
``Task.joints``, the order in which they are listed.
"""

from __future__ import annotations

import math
import reprlib
from bisect import bisect_right
from collections.abc import Collection, Hashable, Mapping, Sequence
from dataclasses import asdict, dataclass, is_dataclass
from functools import cached_property
from itertools import accumulate
from typing import TYPE_CHECKING, Any, ClassVar, Generic, NamedTuple, TypeVar, final

from lockprobe.foundation.errors import BadValue, UserMistake
from lockprobe.trial.record import Decision, Fact, Outcome, Percept, Situation, Task, Turn, told_outcome

if TYPE_CHECKING:
    import numpy as np

Memory = TypeVar("Memory", bound=Hashable)

_MOST = 1024
"""Memories whose probabilities a policy caches."""


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """A policy's view of its task, in numbers.

    Attributes:
        joints: How many there are.
        target: The target's index in the listing.
        places: Position of each joint on the panel, in the order of the listing; empty where it is not shown.
    """

    joints: int
    target: int
    places: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Told:
    """One report, in numbers: of the joint attempted, and whether it moved, as reported.

    Attributes:
        shifted: Joints reported away from their reported start, bit j for joint j; None where positions are not told.
        states_only: Whether positions are told and no outcome, so that ``moved`` is inferred by comparing them.
        odd: Whether it corrects what was said first, or a remark comes with it.
    """

    joint: int
    moved: bool
    shifted: int | None = None
    states_only: bool = False
    odd: bool = False

    @property
    def outcome(self) -> Outcome:
        """What was told, as a claim."""
        return "moved" if self.moved else "blocked"


def tell(task: Task, percept: Percept, past: Sequence[Turn], remark: str = "") -> Told | None:
    """A percept in numbers; None if it reports on no joint.

    Where positions are told and no outcome, the joint counts as moved if its told position changed. ``past`` holds the
    remembered exchanges before the percept, oldest first. The first look tells where the joints started; if it is
    forgotten, all joints are assumed to have started at 0. ``remark`` is what is said with the report.
    """
    if percept.joint is None or (outcome := told_outcome(task, percept, past)) is None:
        return None
    positions = percept.positions
    shifted = None
    if positions is not None:
        first = past[0].percept if past and past[0].percept.joint is None else None
        start = (False,) * len(positions) if first is None else first.positions
        if start is not None:
            shifted = sum([1 << j for j, now in enumerate(positions) if now != start[j]])
    return Told(
        joint=task.joints.index(percept.joint),
        moved=outcome == "moved",
        shifted=shifted,
        states_only=percept.outcome is None,
        odd=percept.corrects is not None or bool(remark),
    )


def refuse_pictures(percept: Percept, reader: str) -> None:
    """Refuse an observation of pictures alone to an agent that reads only reports."""
    if percept.pictures and percept.positions is None and percept.outcome is None:
        raise BadValue("modality", "pictures", f"reports: {reader} cannot read pictures; viewer:STRATEGY can")


def opened_after(opened: int, told: Told) -> int:
    """Joints believed away from their start, bit j for joint j: as told, or else as the outcomes imply."""
    return opened ^ (told.moved << told.joint) if told.shifted is None else told.shifted


def evenly(joints: Collection[int], view: View, lapse: float = 0.0) -> tuple[float, ...]:
    """Equal probabilities for some joints, or with probability ``lapse`` for all; shape (view.joints,)."""
    by_lapse = lapse / view.joints
    meant = by_lapse + (1 - lapse) / len(joints)
    return tuple([meant if joint in joints else by_lapse for joint in range(view.joints)])


def running_sums(probabilities: Sequence[float]) -> list[float]:
    """The sums of the probabilities up to each joint; infinite from the last possible one on, for rounding errors.

    A random number in [0, 1) draws the first joint whose sum exceeds it: ``bisect_right(sums, number)``.
    """
    last = max(j for j, probability in enumerate(probabilities) if probability > 0)
    return [*list(accumulate(probabilities))[:last], *[math.inf] * (len(probabilities) - last)]


class Recall(NamedTuple, Generic[Memory]):
    """A situation (task, past, percept and remark), the view of it, the memory that it leaves, and its report."""

    asked: tuple[Task, tuple[Turn, ...], Percept, str]
    view: View
    memory: Memory
    told: Told | None


class Policy(Generic[Memory]):
    """A rule with a memory. As an :class:`lockprobe.trial.protocols.Agent` it recomputes its memory from the situation.

    It caches its last recall, so that no report is read twice within a trial, and its probabilities by memory, which
    trials share. A cache is used only if the situation continues the cached one, or the memory is the same, so it never
    changes a decision.

    Attributes:
        before: Its memory before the first step, where that does not depend on the task.
        heeds_reports: Whether what it is told changes what it does.
        exact: Whether its probabilities go into the record.
        heeds_panel: Whether it matters where the joints lie on the panel.
    """

    before: ClassVar[Any] = None
    heeds_reports: ClassVar[bool] = True
    exact: ClassVar[bool] = False
    heeds_panel: bool = True
    _last_recall: Recall[Memory] | None = None

    @property
    def facts(self) -> Mapping[str, Fact]:
        """Its parameters, for the record."""
        return asdict(self) if is_dataclass(self) and not isinstance(self, type) else {}

    def begin(self, view: View) -> Memory:
        """The memory before the first step; by default :attr:`before`."""
        return self.before  # type: ignore[no-any-return]

    def remember(self, view: View, memory: Memory, told: Told) -> Memory:
        """The memory after a report; by default it stays the same."""
        return memory

    def remember_silence(self, view: View, memory: Memory, joint: int) -> Memory:
        """The memory after an attempt of which nothing is told; by default it stays the same."""
        return memory

    def probabilities(self, view: View, memory: Memory) -> tuple[float, ...]:
        """The probability of each joint, shape (joints,)."""
        raise NotImplementedError

    def claim(self, memory: Memory, told: Told) -> Outcome | None:
        """What it thinks that its last action did: what it was told, if it heeds reports."""
        return told.outcome if self.heeds_reports else None

    @final
    def chances(self, view: View, memory: Memory) -> tuple[float, ...]:
        """Its probabilities, checked, so that a mistake in a class is a message and never a success rate."""
        found = self.probabilities(view, memory)
        try:
            numbers = tuple(map(float, found))
        except (TypeError, ValueError):
            numbers = ()
        if len(numbers) == view.joints and min(numbers) >= 0 and abs(math.fsum(numbers) - 1) <= 1e-6:
            return numbers
        wanted = f"{view.joints} numbers >= 0 that sum to 1 are expected"
        raise UserMistake(f"{type(self).__name__}.probabilities returned {reprlib.repr(found)}: {wanted}")

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """Choose the next joint from all reports so far."""
        known, cached = self.recall(situation), self._cached
        if (found := cached.get(about := (known.view, known.memory))) is None:
            chances = self.chances(*about)
            if self.exact or len(cached) >= _MOST:  # the memories of exact ones are large, and no two trials have one
                cached.clear()
            found = cached[about] = chances, running_sums(chances)
        joint = situation.task.joints[bisect_right(found[1], rng.random())]
        claimed = None if known.told is None else self.claim(known.memory, known.told)
        return Decision(joint=joint, claimed=claimed, probabilities=found[0] if self.exact else None)

    @cached_property
    def _cached(self) -> dict[tuple[View, Memory], tuple[tuple[float, ...], list[float]]]:
        return {}

    def recall(self, situation: Situation) -> Recall[Memory]:
        """The memory after all reports so far. If the last recall was one step earlier, only the newest is added."""
        task, past, percept, remark = situation.task, situation.past, situation.percept, situation.briefing.remark
        if percept.pictures and self.heeds_reports:
            refuse_pictures(percept, type(self).__name__)
        known, told = self._last_recall, None
        if known is not None and past and known.asked == (task, past[:-1], past[-1].percept, past[-1].remark):
            view, memory, heard = known.view, known.memory, len(past)
        else:
            panel = task.places if self.heeds_panel else ()
            view = View(joints=len(task.joints), target=task.joints.index(task.target), places=panel)
            memory, heard = self.begin(view), 0
        for step in range(heard, len(past) + 1):
            report, said = (past[step].percept, past[step].remark) if step < len(past) else (percept, remark)
            told = tell(task, report, past[:step], said)
            if told is not None:
                memory = self.remember(view, memory, told)
            elif step:
                memory = self.remember_silence(view, memory, task.joints.index(past[step - 1].decision.joint))
        last = Recall((task, past, percept, remark), view, memory, told)
        object.__setattr__(self, "_last_recall", last)  # many policies are frozen dataclasses
        return last
