"""Strategies: four that ignore all reports, the human-inspired one and its variants, and mechanisms.

The paper uses a strategy derived from human behaviour (Sec. 3.1) whose algorithm is not public. All presets are
*reconstructions*; ``docs/agents.md`` says what each reaches. Mechanisms are models in the statistical sense: each gives
every choice a probability. All look at what is told, never at the truth.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

from lockprobe.agents.policy import Policy, Told, View, evenly, opened_after
from lockprobe.foundation.validation import Checked, Share, Within
from lockprobe.trial.record import Fact


@dataclass(frozen=True)
class RandomAgent(Policy[None]):
    """A random choice among all joints at every step, which solves the chance level on average."""

    heeds_reports = heeds_panel = False

    def probabilities(self, view: View, memory: None) -> tuple[float, ...]:
        """Equal for all joints."""
        return evenly(range(view.joints), view)


@dataclass(frozen=True)
class RandomNoRepeat(Policy[int]):
    """A random choice among all joints except that of the last report; among all before there is one."""

    heeds_reports = heeds_panel = False
    before = -1

    def remember(self, view: View, memory: int, told: Told) -> int:
        """The joint of the last report."""
        return told.joint

    def probabilities(self, view: View, memory: int) -> tuple[float, ...]:
        """Equal for all others."""
        return evenly([joint for joint in range(view.joints) if joint != memory], view)


@dataclass(frozen=True)
class RoundRobin(Policy[int]):
    """The joints in listed order, again and again; after a missing report the same one again."""

    heeds_reports = heeds_panel = False
    before = 0

    def remember(self, view: View, memory: int, told: Told) -> int:
        """How many steps were taken, up to one round."""
        return (memory + 1) % view.joints

    def probabilities(self, view: View, memory: int) -> tuple[float, ...]:
        """One of them."""
        return evenly([memory], view)


class RightToLeft(RoundRobin):
    """The joints from right to left on the panel, again and again, whatever happens: what places alone give away."""

    heeds_panel = True

    def remember_silence(self, view: View, memory: int, joint: int) -> int:
        """The same: it needs no report."""
        return (memory + 1) % view.joints

    def probabilities(self, view: View, memory: int) -> tuple[float, ...]:
        """One of them; the last in the list where no places are known."""
        order = sorted(range(view.joints), key=lambda joint: (view.places[joint : joint + 1], joint))
        return evenly([order[-1 - memory]], view)


class Tried(NamedTuple):
    """The strategy's memory. A set of joints is a number with bit j for joint j."""

    failed: int = 0  # joints that failed since the last perceived move
    opened: int = 0  # joints believed away from their start
    moved: int = -1  # the joint that moved last; -1 before
    seen: int = 0  # attempts made in each configuration: bit opened * joints + joint; kept by memory=configuration


@dataclass(frozen=True, kw_only=True)
class HumanInspired(Checked, Policy[Tried]):
    """Rules joints out by what it was told, spares some and takes one of the rest, by default the target first.

    1. With ``target="first"``: the target, unless it is ruled out.
    2. Else, at random or the nearest, a joint that is neither ruled out nor spared (with ``target="last"``: but the
       target, and then the target).
    3. Else one that is not ruled out.
    4. Else, since the reports contradict each other, any joint.

    Attributes:
        target: When the target is tried: ``first``, ``last``, or like ``any`` other joint.
        memory: What rules a joint out: that it failed ``since-move``, that it was tried in this ``configuration``,
            or ``none``.
        spare: What is left for later: joints that are ``opened``, the one that ``moved`` last, or ``none``.
        nearest: Whether the nearest to the joint that moved last is taken, where the panel is shown.
        lapse: Probability of any joint instead, [0, 1].
    """

    before: ClassVar[Tried] = Tried()

    target: Literal["first", "last", "any"] = "first"
    memory: Literal["since-move", "configuration", "none"] = "since-move"
    spare: Literal["opened", "moved", "none"] = "opened"
    nearest: bool = False
    lapse: Share = 0.0

    @property
    def heeds_panel(self) -> bool:  # type: ignore[override]  # a flag of each one, not of the class
        """Whether distances matter."""
        return self.nearest

    @property
    def facts(self) -> Mapping[str, Fact]:
        """Its parameters; the default preset has none to state."""
        return {} if self == HumanInspired() else super().facts

    def remember(self, view: View, memory: Tried, told: Told) -> Tried:
        """The failed, moved and tried joints after this report."""
        attempt = 1 << (memory.opened * view.joints + told.joint) if self.memory == "configuration" else 0
        return Tried(
            failed=0 if told.moved else memory.failed | 1 << told.joint,
            opened=opened_after(memory.opened, told),
            moved=told.joint if told.moved else memory.moved,
            seen=memory.seen | attempt,
        )

    def probabilities(self, view: View, memory: Tried) -> tuple[float, ...]:
        """Equal for all joints that the rules allow; lapses are equal for all joints."""
        ruled_out = memory.failed if self.memory == "since-move" else 0
        if self.memory == "configuration":
            ruled_out = memory.seen >> (memory.opened * view.joints) & ((1 << view.joints) - 1)
        if self.target == "first" and not ruled_out >> view.target & 1:
            return evenly([view.target], view, self.lapse)
        untried = [joint for joint in range(view.joints) if not ruled_out >> joint & 1]
        spared = memory.opened if self.spare == "opened" else 0
        if self.spare == "moved" and memory.moved >= 0:
            spared = 1 << memory.moved
        fresh = [joint for joint in untried if not spared >> joint & 1]
        if self.target == "last" and view.target in untried:
            fresh = [joint for joint in fresh if joint != view.target] or [view.target]
        if self.nearest and memory.moved >= 0 and view.places and fresh:
            x, y = view.places[memory.moved]
            far = {j: round((view.places[j][0] - x) ** 2 + (view.places[j][1] - y) ** 2, 9) for j in fresh}
            fresh = [joint for joint in fresh if far[joint] == min(far.values())]
        return evenly(fresh or untried or range(view.joints), view, self.lapse)


_Pull = Annotated[float, Within(-1e6, 1e6)]


class Traces(NamedTuple):
    """The memory of the softmax model."""

    failures: tuple[float, ...]  # failure trace of each joint, [0, 1], shape (joints,)
    opened: int = 0  # joints believed away from their start, bit j for joint j
    last: int = -1  # the joint attempted last; -1 before
    moved: bool = False  # whether it moved, as told


@dataclass(frozen=True, kw_only=True)
class SoftmaxMemory(Checked, Policy[Traces]):
    """A softmax over the joints: joint j has probability proportional to exp(U_j), a sum of pulls.

    ``U_j = target [j is the target] + closed [j is where it was at the start, as told] - failure F_j
    + recent [j was attempted last] + stay [j was attempted last, and moved, as told] - position r_j``

    with the failure trace F_j, 1 when j has just failed, times ``decay`` with every further step and times
    ``1 - reset`` with every perceived move, both in [0, 1], and r_j the joint's place in the listing from 0 (first) to
    1 (last). The pulls are in units of the temperature, which is therefore 1.
    """

    exact: ClassVar[bool] = True
    heeds_panel = False

    target: _Pull = 0.0
    closed: _Pull = 0.0
    failure: _Pull = 0.0
    decay: Share = 1.0
    reset: Share = 1.0
    recent: _Pull = 0.0
    stay: _Pull = 0.0
    position: _Pull = 0.0

    def begin(self, view: View) -> Traces:
        """No failures."""
        return Traces(failures=(0.0,) * view.joints)

    def remember(self, view: View, memory: Traces, told: Told) -> Traces:
        """Traces fade, and the new failure is written over its own."""
        kept = self.decay * (1 - self.reset) if told.moved else self.decay
        failures = [trace * kept for trace in memory.failures]
        if not told.moved:
            failures[told.joint] = 1.0
        return Traces(tuple(failures), opened_after(memory.opened, told), told.joint, told.moved)

    def probabilities(self, view: View, memory: Traces) -> tuple[float, ...]:
        """The softmax of the pulls."""
        pulls = []
        for joint, failure in enumerate(memory.failures):
            pull = -self.failure * failure - self.position * joint / max(view.joints - 1, 1)
            if joint == view.target:
                pull += self.target
            if not memory.opened >> joint & 1:
                pull += self.closed
            if joint == memory.last:
                pull += self.recent + self.stay * memory.moved
            pulls.append(pull)
        weights = [math.exp(pull - max(pulls)) for pull in pulls]
        return tuple(weight / sum(weights) for weight in weights)


_CYCLE = 3
"""Joints of a loop breaker's cycle, or all if there are fewer."""


class Round(NamedTuple):
    """The memory of a loop breaker."""

    told: tuple[int, ...]  # what it was last told of each joint: 0 nothing, 1 blocked, 2 moved; shape (joints,)
    cycle: tuple[int, ...] = ()  # the joints of its cycle that are drawn so far; of a whole one the next comes first
    free: int = 0  # how many random actions are left
    last: int = -1  # the joint attempted last while free; -1 else


@dataclass(frozen=True, kw_only=True)
class LoopBreaker(Policy[Round]):
    """It goes round a cycle of three joints that it draws at the start, until an odd report frees it.

    A report is odd if it contradicts the last one of that joint, or if its form is odd: a correction, a remark, or no
    report. Then it forgets what it was told, acts three times at random without repeats, and draws a new cycle. So lies
    help it, and not through what they say.
    """

    heeds_panel = False

    def begin(self, view: View) -> Round:
        """No joint of the cycle is drawn."""
        return Round((0,) * view.joints)

    def remember(self, view: View, memory: Round, told: Told) -> Round:
        """On along the cycle, or out of it."""
        if memory.free or told.odd or memory.told[told.joint] not in (0, 1 + told.moved):
            return self.remember_silence(view, memory, told.joint)
        reports = (*memory.told[: told.joint], 1 + told.moved, *memory.told[told.joint + 1 :])
        if len(memory.cycle) == min(_CYCLE, view.joints):
            return Round(reports, (*memory.cycle[1:], memory.cycle[0]))
        return Round(reports, (*memory.cycle, told.joint))

    def remember_silence(self, view: View, memory: Round, joint: int) -> Round:
        """A missing report is odd."""
        free = memory.free - 1 if memory.free else 3
        return Round((0,) * view.joints, free=free, last=joint if free else -1)

    def probabilities(self, view: View, memory: Round) -> tuple[float, ...]:
        """The next joint of the cycle; any that is not in it while it is drawn; any but the last while free."""
        if len(memory.cycle) == min(_CYCLE, view.joints):
            return evenly([memory.cycle[0]], view)
        barred = (memory.last,) if memory.free else memory.cycle
        return evenly([joint for joint in range(view.joints) if joint not in barred], view)


STRATEGIES: Mapping[str, Policy[Any]] = {
    "random": RandomAgent(),
    "random-no-repeat": RandomNoRepeat(),
    "round-robin": RoundRobin(),
    "right-to-left": RightToLeft(),
    "human-inspired": HumanInspired(),
    "human-inspired:target-first": HumanInspired(),
    "human-inspired:target-last": HumanInspired(target="last"),
    "human-inspired:target-any": HumanInspired(target="any"),
    "human-inspired:proximity": HumanInspired(target="any", nearest=True),
    "human-inspired:per-configuration": HumanInspired(target="any", memory="configuration", spare="moved"),
    "human-inspired:target-first-per-configuration": HumanInspired(memory="configuration", spare="moved"),
    "cognitive:softmax-memory": SoftmaxMemory(),
    "cognitive:loop-breaker": LoopBreaker(),
    "cognitive:careful": SoftmaxMemory(target=2, closed=2, failure=4),
    "cognitive:perseverant": SoftmaxMemory(target=-0.7, closed=2.1, failure=6.1, decay=0, recent=2.4, stay=1),
    "cognitive:insistent": SoftmaxMemory(target=0.6, closed=2.7, failure=1.4, recent=3.6, stay=-1.5),
}
"""By name; the ideal observer is not among them, as its arrays take long to import.

``target-first`` gives the paper's reference curve: 80 % by step 9 and 100 % by step 20. ``proximity`` is
``heuristic_proximity`` of the public code (Baum et al., IROS 2017) with its memory "also in the beginning"; where that
code stops, because nothing is left, ours goes on with what has not failed. The characters were found by trying: false
reports hurt the careful one and help the perseverant one; of the insistent one a few help and many hurt.
"""

CHARACTERS: Mapping[str, str] = {
    "cognitive:careful": "Turns to what has neither moved nor failed, the target first.",
    "cognitive:perseverant": "Does again what has just moved, and so undoes it.",
    "cognitive:insistent": "Does again what has just failed.",
}
"""What a softmax memory does with the settings of a name."""
