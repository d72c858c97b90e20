"""The intervention ``force``: the experimenter chooses the joint at one step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from lockprobe.errors import BadValue

if TYPE_CHECKING:
    import numpy as np

    from lockprobe.record import Moment, Task

__all__ = ["Force"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Force:
    """At one step a joint that is drawn is attempted, whatever the agent chose, and truthfully reported.

    One number is drawn per step.

    Attributes:
        at: The step, from 1; 0 for none.

    Raises:
        BadValue: If it is none.
    """

    name: ClassVar[str] = "force"
    at: int = 0

    def __post_init__(self) -> None:
        if self.at < 0:
            raise BadValue("at", self.at, "a step from 1, or 0 for none")

    def act(self, joint: str, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> str:
        """The joint, or at that step the one that is drawn."""
        which = int(rng.random() * len(task.joints))
        return task.joints[which] if len(past) == self.at else joint
