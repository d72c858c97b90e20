"""Strategies that follow rules: four that ignore all reports, and the human-inspired one with its variants.

The paper uses a strategy derived from human behaviour (Sec. 3.1) whose algorithm is not public. All presets are
*reconstructions*. What they reach on ``chain-4`` when told the truth (mean steps, 80 % by, all by; exact):

* ``target-first`` (default) 8.5, 9, 10: the paper's reference curve, 80 % by step 9 and 100 % by step 20.
* ``target-last`` 5.5, 6, 7: the target only when nothing else is left to try.
* ``target-any`` 7, 8, 10: the target like any other joint.
* ``proximity``: after a joint has moved, the nearest on the panel that has neither moved nor failed since. This is
  ``heuristic_proximity`` of the public code (Baum et al., IROS 2017) with its memory "also in the beginning"; where
  that code stops, because nothing is left, ours goes on with what has not failed. The layout decides.
* ``per-configuration``: nothing twice in the same configuration, and not the joint that moved last: half of the trials
  by step 9, 84 % by 20.
* ``target-first-per-configuration``: the same, but the target first after every change: 46 % by step 9, all by 13.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, NamedTuple

from lockprobe.agents.policy import Policy, Told, View, evenly, opened_after
from lockprobe.foundation.validation import check_probability
from lockprobe.trial.record import Fact

PRESETS: Mapping[str, Mapping[str, object]] = {
    "target-first": {},
    "target-last": {"target": "last"},
    "target-any": {"target": "any"},
    "proximity": {"target": "any", "nearest": True},
    "per-configuration": {"target": "any", "memory": "configuration", "spare": "moved"},
    "target-first-per-configuration": {"memory": "configuration", "spare": "moved"},
}


class RandomAgent(Policy[None]):
    """A random choice among all joints at every step. Its success is the box's chance level."""

    looks = heeds_panel = False

    def begin(self, view: View) -> None:
        """Nothing."""

    def remember(self, view: View, memory: None, told: Told) -> None:
        """Nothing."""

    def probabilities(self, view: View, memory: None) -> tuple[float, ...]:
        """Equal for all joints."""
        return evenly(range(view.joints), view)


class RandomNoRepeat(Policy[int]):
    """A random choice among all joints except the one attempted last."""

    looks = heeds_panel = False

    def begin(self, view: View) -> int:
        """No joint was attempted."""
        return -1

    def remember(self, view: View, memory: int, told: Told) -> int:
        """The joint attempted last."""
        return told.joint

    def probabilities(self, view: View, memory: int) -> tuple[float, ...]:
        """Equal for all others."""
        return evenly([joint for joint in range(view.joints) if joint != memory], view)


class RoundRobin(Policy[int]):
    """The joints in listed order, again and again, whatever happens."""

    looks = heeds_panel = False

    def begin(self, view: View) -> int:
        """No step was taken."""
        return 0

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
        order = sorted(range(view.joints), key=lambda joint: (view.places[joint] if view.places else (0.0, 0.0), joint))
        return evenly([order[-1 - memory]], view)


class Tried(NamedTuple):
    """The strategy's memory. A set of joints is a number with bit j for joint j."""

    failed: int = 0  # joints that failed since the last perceived move
    opened: int = 0  # joints believed away from their start
    moved: int = -1  # the joint that moved last; -1 before
    seen: int = 0  # attempts made in each configuration: bit opened * joints + joint; kept by memory=configuration


@dataclass(frozen=True, kw_only=True)
class HumanInspired(Policy[Tried]):
    """After every perceived change try the target; never retry a failed joint until something has moved.

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

    Raises:
        BadValue: If ``lapse`` is no probability.
    """

    target: Literal["first", "last", "any"] = "first"
    memory: Literal["since-move", "configuration", "none"] = "since-move"
    spare: Literal["opened", "moved", "none"] = "opened"
    nearest: bool = False
    lapse: float = 0.0

    def __post_init__(self) -> None:
        check_probability("lapse", self.lapse)

    @property
    def heeds_panel(self) -> bool:  # type: ignore[override]  # a flag of each one, not of the class
        """Whether distances matter."""
        return self.nearest

    @property
    def facts(self) -> Mapping[str, Fact]:
        """Its parameters; the default preset has none to state."""
        return {} if self == HumanInspired() else super().facts

    def begin(self, view: View) -> Tried:
        """Nothing was tried."""
        return Tried()

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
