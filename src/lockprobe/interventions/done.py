"""What is *done* and *remembered*: another joint than the chosen one, and a past that is cut."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from lockprobe.foundation.errors import BadValue
from lockprobe.interventions.told import AtRandomSteps
from lockprobe.trial.record import Moment, Task, Turn

if TYPE_CHECKING:
    import numpy as np


@dataclass(frozen=True, slots=True, kw_only=True)
class Tremble(AtRandomSteps):
    """With probability p a random other joint is attempted instead of the chosen one, and reported truthfully."""

    name: ClassVar[str] = "tremble"

    def act(self, joint: str, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> str:
        """The joint, or another one."""
        slips, which = rng.random(2)
        others = [label for label in task.joints if label != joint]
        return others[int(which * len(others))] if self.hits(slips, len(past)) else joint


@dataclass(frozen=True, slots=True, kw_only=True)
class Force:
    """At one step a given or random joint is attempted instead of the agent's choice, and reported truthfully.

    The step is from 1, 0 for none; the joint is a label, or empty for one that is drawn, each equally likely.
    """

    name: ClassVar[str] = "force"
    at: int = 0
    joint: str = ""

    def __post_init__(self) -> None:
        if self.at < 0:
            raise BadValue("at", self.at, "a step from 1, or 0 for none")

    def act(self, joint: str, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> str:
        """The joint, or at that step the one that is given or drawn."""
        which = int(rng.random() * len(task.joints))
        if len(past) != self.at:
            return joint
        if self.joint and self.joint not in task.joints:
            raise BadValue("joint", self.joint, f"one of {', '.join(task.joints)}")
        return self.joint or task.joints[which]


@dataclass(frozen=True, slots=True, kw_only=True)
class History:
    """The agent remembers only the ``last`` exchanges (choice and report); its task and the current report stay.

    Nothing is drawn.
    """

    name: ClassVar[str] = "history"
    last: int = 5

    def __post_init__(self) -> None:
        if self.last < 0:
            raise BadValue("last", self.last, "a whole number from 0")

    def recall(
        self, turns: tuple[Turn, ...], past: tuple[Moment, ...], task: Task, rng: np.random.Generator
    ) -> tuple[Turn, ...]:
        """The newest exchanges."""
        return turns[len(turns) - self.last :] if self.last < len(turns) else turns
