"""Agents that go round a cycle until something that they are told frees them; they differ in what does.

Lies help all of them, each through another property of a report: that it is odd at all, that it is new, how much there
is of it, that it does not contradict itself, or that it contradicts what was known.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from lockprobe.agents.policy import Policy, Told, View, evenly
from lockprobe.foundation.errors import BadValue

__all__ = ["AnyFalsehood", "FormByLength", "LoopBreaker", "Novelty", "Round", "Sceptic"]

FREE = 3
"""Random actions after a report that frees."""

_LENGTH = 3
"""Joints of the cycle."""


@dataclass(frozen=True, slots=True)
class Round:
    """The memory of a loop breaker.

    Attributes:
        told: What it was last told of each joint: 0 nothing, 1 that it was blocked, 2 that it moved; shape (joints,).
        cycle: The joints of its cycle that are drawn so far, in order.
        at: Which of them comes next.
        free: How many random actions are left.
        last: The joint attempted last while free; -1 else.
        freed: Whether something has freed it before; only :class:`Novelty` keeps that.
    """

    told: tuple[int, ...]
    cycle: tuple[int, ...] = ()
    at: int = 0
    free: int = 0
    last: int = -1
    freed: bool = False


@dataclass(frozen=True, kw_only=True)
class LoopBreaker(Policy[Round]):
    """It goes round a cycle of three joints that it draws at the start, until an odd report frees it.

    A report is odd if it contradicts the last one of that joint, or if its form is odd: a correction, a remark, or no
    report. Then it forgets what it was told, acts three times at random without repeats, and draws a new cycle.
    """

    heeds_remarks = True

    def begin(self, view: View) -> Round:
        """No joint of the cycle is drawn.

        Raises:
            BadValue: If the box has fewer joints than a cycle.
        """
        if view.joints < _LENGTH:
            raise BadValue("box", f"{view.joints} joints", f"at least {_LENGTH} joints, for a cycle")
        return Round((0,) * view.joints)

    def remember(self, view: View, memory: Round, told: Told) -> Round:
        """On along the cycle, or out of it."""
        reports = (*memory.told[: told.joint], 1 + told.moved, *memory.told[told.joint + 1 :])
        return self._after(memory, told.joint, reports, self.freed_for(memory, told))

    def remember_silence(self, view: View, memory: Round, joint: int) -> Round:
        """A missing report is odd."""
        return self._after(memory, joint, memory.told, FREE)

    def freed_for(self, memory: Round, told: Told) -> int:
        """The number of random actions after a report; 0 if it does not free."""
        return FREE if told.odd or _contradicts(memory, told) else 0

    def _after(self, memory: Round, joint: int, reports: tuple[int, ...], freed_for: int) -> Round:
        if memory.free or freed_for:
            free = memory.free - 1 if memory.free else freed_for
            return Round((0,) * len(reports), free=free, last=joint if free else -1)
        cycle = memory.cycle if len(memory.cycle) == _LENGTH else (*memory.cycle, joint)
        return Round(reports, cycle, (memory.at + 1) % _LENGTH)

    def probabilities(self, view: View, memory: Round) -> tuple[float, ...]:
        """The next joint of the cycle; any that is not in it while it is drawn; any but the last while free."""
        if len(memory.cycle) == _LENGTH:
            return evenly([memory.cycle[memory.at]], view)
        barred = (memory.last,) if memory.free else memory.cycle
        return evenly([joint for joint in range(view.joints) if joint not in barred], view)


class FormByLength(LoopBreaker):
    """A loop breaker that a correction, which has two statements, sets free for twice as long as a remark or a lie."""

    def freed_for(self, memory: Round, told: Told) -> int:
        """Twice as many after a correction."""
        return 2 * FREE if told.corrects is not None else super().freed_for(memory, told)


class Novelty(LoopBreaker):
    """A loop breaker that the first odd report of a trial frees; it takes no notice of later ones."""

    def freed_for(self, memory: Round, told: Told) -> int:
        """None after the first time."""
        return 0 if memory.freed else super().freed_for(memory, told)

    def _after(self, memory: Round, joint: int, reports: tuple[int, ...], freed_for: int) -> Round:
        after = super()._after(memory, joint, reports, 0 if memory.freed else freed_for)
        return replace(after, freed=memory.freed or freed_for > 0)


class AnyFalsehood(LoopBreaker):
    """A loop breaker that any statement frees which contradicts the last one of the joint; the form does nothing."""

    heeds_remarks = False

    def freed_for(self, memory: Round, told: Told) -> int:
        """As many after one contradiction as after two."""
        statements = (told,) if told.corrects is None else (told.corrects, told)
        return FREE if any(_contradicts(memory, said) for said in statements) else 0


class Sceptic(LoopBreaker):
    """A loop breaker that takes no notice of a report whose two statements disagree."""

    def freed_for(self, memory: Round, told: Told) -> int:
        """None after statements that disagree."""
        disagree = told.corrects is not None and told.corrects.moved != told.moved
        return 0 if disagree else super().freed_for(memory, told)


def _contradicts(memory: Round, told: Told) -> bool:
    """Whether a statement contradicts what was last told of the joint."""
    return memory.told[told.joint] not in (0, 1 + told.moved)
