"""The intervention ``force``: the experimenter chooses the joint at one step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from lockprobe.foundation.errors import BadValue
from lockprobe.trial.record import Moment, Task


@dataclass(frozen=True, slots=True, kw_only=True)
class Force:
    """At one step a given or random joint is attempted instead of the agent's choice, and reported truthfully.

    Attributes:
        at: The step, from 1; 0 for none.
        joint: Label of the joint; empty for one that is drawn, each equally likely.

    Raises:
        BadValue: If the step is none, or, in a trial, the joint.
    """

    name: ClassVar[str] = "force"
    at: int = 0
    joint: str = ""

    def __post_init__(self) -> None:
        if self.at < 0:
            raise BadValue("at", self.at, "a step from 1, or 0 for none")

    def act(self, joint: str, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> str:
        """The joint, or at that step the one that is drawn."""
        which = int(rng.random() * len(task.joints))
        if len(past) != self.at:
            return joint
        if self.joint and self.joint not in task.joints:
            raise BadValue("joint", self.joint, f"one of {', '.join(task.joints)}")
        return self.joint or task.joints[which]
