"""Agents of known mechanism, to test causal analyses on: whether false reports change success, and through what.

Each is a :class:`Policy`, so its success under every condition, and with it the true effect, is exact
(:func:`lockprobe.propagate`). All look only at what they are told.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from lockprobe.agents.cognitive import SoftmaxMemory
from lockprobe.agents.human_inspired import HumanInspired
from lockprobe.agents.policy import Policy, Told, View, evenly
from lockprobe.agents.strategies import RandomNoRepeat
from lockprobe.errors import BadValue
from lockprobe.record import Fact
from lockprobe.validation import check_probability

__all__ = ["WORLDS", "Believer", "Failures", "LoopBreaker", "LostHalf", "LostPair", "Round"]

_FREE = 3
"""Random actions of the loop breaker after an odd report."""

_LENGTH = 3
"""Joints of its cycle."""


@dataclass(frozen=True, slots=True)
class Round:
    """The memory of the loop breaker.

    Attributes:
        told: What it was last told of each joint: 0 nothing, 1 that it was blocked, 2 that it moved; shape (joints,).
        cycle: The joints of its cycle that are drawn so far, in order.
        at: Which of them comes next.
        free: How many random actions are left.
        last: The joint attempted last while free; -1 else.
    """

    told: tuple[int, ...]
    cycle: tuple[int, ...] = ()
    at: int = 0
    free: int = 0
    last: int = -1


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
        known, now = memory.told[told.joint], 1 + told.moved
        reports = (*memory.told[: told.joint], now, *memory.told[told.joint + 1 :])
        return self._after(memory, told.joint, reports, odd=told.odd or known not in (0, now))

    def remember_silence(self, view: View, memory: Round, joint: int) -> Round:
        """A missing report is odd."""
        return self._after(memory, joint, memory.told, odd=True)

    def _after(self, memory: Round, joint: int, reports: tuple[int, ...], *, odd: bool) -> Round:
        if memory.free or odd:
            free = memory.free - 1 if memory.free else _FREE
            return Round((0,) * len(reports), free=free, last=joint if free else -1)
        cycle = memory.cycle if len(memory.cycle) == _LENGTH else (*memory.cycle, joint)
        return Round(reports, cycle, (memory.at + 1) % _LENGTH)

    def probabilities(self, view: View, memory: Round) -> tuple[float, ...]:
        """The next joint of the cycle; any that is not in it while it is drawn; any but the last while free."""
        if len(memory.cycle) == _LENGTH:
            return evenly([memory.cycle[memory.at]], view)
        barred = (memory.last,) if memory.free else memory.cycle
        return evenly([joint for joint in range(view.joints) if joint not in barred], view)


@dataclass(frozen=True, slots=True)
class Failures:
    """The memory of a believer.

    Attributes:
        failed: Joints that failed since the last perceived move, bit j for joint j.
        due: Whether something has just moved, so that the target is due.
    """

    failed: int = 0
    due: bool = False


@dataclass(frozen=True, kw_only=True)
class Believer(Policy[Failures]):
    """It believes every report: the target after every move, else any joint that has not failed since.

    It takes a corrected report as corrected and learns nothing from one that is withheld.

    Attributes:
        lapse: Probability of any joint instead, [0, 1].

    Raises:
        BadValue: If ``lapse`` is no probability.
    """

    lapse: float = 0.0

    def __post_init__(self) -> None:
        check_probability("lapse", self.lapse)

    @property
    def facts(self) -> Mapping[str, Fact]:
        """Its parameters."""
        return asdict(self)

    def begin(self, view: View) -> Failures:
        """Nothing has failed."""
        return Failures()

    def remember(self, view: View, memory: Failures, told: Told) -> Failures:
        """A move makes all joints worth another attempt."""
        return Failures(0, due=True) if told.moved else Failures(memory.failed | 1 << told.joint)

    def probabilities(self, view: View, memory: Failures) -> tuple[float, ...]:
        """The target when it is due, else equal for all that have not failed; lapses are equal for all."""
        open_ = [joint for joint in range(view.joints) if not memory.failed >> joint & 1]
        meant = [view.target] if memory.due else open_ or list(range(view.joints))
        return evenly(meant, view, self.lapse)


@dataclass(frozen=True, slots=True)
class LostPair:
    """The evidence so far on whether a trial is lost.

    Attributes:
        pair: The first two joints attempted.
        steps: How many attempts so far agree with a cycle over this pair; -1 once one did not.
    """

    pair: tuple[int, ...] = ()
    steps: int = 0


@dataclass(frozen=True, kw_only=True)
class LostHalf(Policy[LostPair]):
    """In half of all trials it cycles over two joints that are not the target; in the others it acts at random.

    Reports mean nothing to it. Which half a trial belongs to shows in its choices alone: their probabilities are those
    of the mixture, given the choices so far.
    """

    looks = False

    def begin(self, view: View) -> LostPair:
        """Nothing was chosen.

        Raises:
            BadValue: If the box has fewer than three joints.
        """
        if view.joints < 3:
            raise BadValue("box", f"{view.joints} joints", "at least three joints: the target and two to cycle over")
        return LostPair()

    def remember(self, view: View, memory: LostPair, told: Told) -> LostPair:
        """The choice counts, not the report."""
        return self.remember_silence(view, memory, told.joint)

    def remember_silence(self, view: View, memory: LostPair, joint: int) -> LostPair:
        """Whether the choice agrees with a cycle over two joints that are not the target."""
        if memory.steps < 0:
            return memory
        fits = (
            joint != view.target and joint not in memory.pair
            if memory.steps < 2
            else (joint == memory.pair[memory.steps % 2])
        )
        if not fits:
            return LostPair(steps=-1)
        return LostPair((*memory.pair, joint) if memory.steps < 2 else memory.pair, memory.steps + 1)

    def probabilities(self, view: View, memory: LostPair) -> tuple[float, ...]:
        """Those of the mixture of both halves, given the choices so far."""
        joints, others = view.joints, view.joints - 1
        lost = 0.0
        if memory.steps >= 0:
            of_lost = [1.0, 1 / others, 1 / (others * (others - 1))][min(memory.steps, 2)]
            lost = of_lost / (of_lost + joints**-memory.steps)
        return tuple((1 - lost) / joints + lost * self._next(view, memory, joint) for joint in range(joints))

    def _next(self, view: View, memory: LostPair, joint: int) -> float:
        """The probability of a joint in a trial that is lost."""
        if memory.steps >= 2:
            return float(joint == memory.pair[memory.steps % 2])
        return 0.0 if joint == view.target or joint in memory.pair else 1 / (view.joints - 1 - memory.steps)


WORLDS: Mapping[str, Any] = {
    "loop-breaker": LoopBreaker,
    "information": lambda: Believer(lapse=0.1),
    "information-hurts": HumanInspired,
    "perseverant": lambda: SoftmaxMemory(stay=2.2),
    "careful-believer": Believer,
    "irrelevant": RandomNoRepeat,
    "lost-half": LostHalf,
}
"""The worlds by name, as in ``world:loop-breaker``."""
