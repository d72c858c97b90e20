"""Agents that differ in what they hear: which statement of a report in two they believe, and whether its form acts.

Each wraps a policy, which believes what it hears.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

from lockprobe.agents.policy import Policy, Told, View, evenly
from lockprobe.foundation.validation import check_choice
from lockprobe.trial.record import Fact

__all__ = ["Hears", "Jolt", "Jolted"]

Believes = Literal["first", "last", "agreed", "neither"]
"""Which statement is believed: always the first, or always the last; either if they agree, else none; none."""

_FREE = 3
"""Random actions after a correction that makes an agent start afresh."""


@dataclass(frozen=True, kw_only=True)
class Hears(Policy[Any]):
    """A policy that hears one statement of a report in two, and no remarks.

    Attributes:
        policy: It believes what it hears.
        believes: Which statement that is. Of a report that is not believed it learns nothing.

    Raises:
        BadValue: If there is no such choice.
    """

    policy: Policy[Any]
    believes: Believes

    def __post_init__(self) -> None:
        check_choice("believes", self.believes, get_args(Believes))

    @property
    def facts(self) -> Mapping[str, Fact]:
        """What it believes, and the policy's parameters."""
        return {"believes": self.believes, **self.policy.facts}

    def begin(self, view: View) -> Any:
        """As the policy begins."""
        return self.policy.begin(view)

    def remember(self, view: View, memory: Any, told: Told) -> Any:
        """As the policy remembers a plain report of what is heard, or none."""
        first = told if told.corrects is None else told.corrects
        agreed = (first.moved, first.shifted) == (told.moved, told.shifted)
        heard = told.corrects is None or (self.believes != "neither" and (self.believes != "agreed" or agreed))
        if not heard:
            return self.policy.remember_silence(view, memory, told.joint)
        return self.policy.remember(view, memory, _plain(first if self.believes == "first" else told))

    def remember_silence(self, view: View, memory: Any, joint: int) -> Any:
        """As the policy does."""
        return self.policy.remember_silence(view, memory, joint)

    def probabilities(self, view: View, memory: Any) -> tuple[float, ...]:
        """Those of the policy."""
        return self.policy.probabilities(view, memory)


@dataclass(frozen=True, slots=True)
class Jolt:
    """The memory of an agent that starts afresh.

    Attributes:
        kept: The policy's memory.
        free: How many random actions are left.
    """

    kept: Any
    free: int = 0


@dataclass(frozen=True, kw_only=True)
class Jolted(Policy[Jolt]):
    """A policy that any correction makes start afresh: it forgets everything and acts three times at random.

    It believes the last statement, and does not heed remarks.

    Attributes:
        policy: It believes what it is told.
    """

    policy: Policy[Any]

    @property
    def facts(self) -> Mapping[str, Fact]:
        """The policy's parameters."""
        return self.policy.facts

    def begin(self, view: View) -> Jolt:
        """As the policy begins."""
        return Jolt(self.policy.begin(view))

    def remember(self, view: View, memory: Jolt, told: Told) -> Jolt:
        """Nothing after a correction, else as the policy does."""
        if told.corrects is not None:
            return Jolt(self.policy.begin(view), _FREE)
        return Jolt(self.policy.remember(view, memory.kept, _plain(told)), max(memory.free - 1, 0))

    def remember_silence(self, view: View, memory: Jolt, joint: int) -> Jolt:
        """As the policy does."""
        return Jolt(self.policy.remember_silence(view, memory.kept, joint), max(memory.free - 1, 0))

    def probabilities(self, view: View, memory: Jolt) -> tuple[float, ...]:
        """Any joint after a correction, else those of the policy."""
        return evenly(range(view.joints), view) if memory.free else self.policy.probabilities(view, memory.kept)


def _plain(told: Told) -> Told:
    """A statement as a report of its own, without a remark."""
    return replace(told, corrects=None, remarked=False)
