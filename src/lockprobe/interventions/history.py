"""The intervention ``history``: the agent knows only the newest exchanges of its past."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from lockprobe.foundation.errors import BadValue
from lockprobe.trial.record import Task, Turn


@dataclass(frozen=True, slots=True, kw_only=True)
class History:
    """The agent remembers only the newest exchanges; its task and the current report stay unchanged.

    Nothing is drawn.

    Attributes:
        last: The number of exchanges (choice and report) that it remembers, from 0.

    Raises:
        BadValue: If it is negative.
    """

    name: ClassVar[str] = "history"
    last: int = 5

    def __post_init__(self) -> None:
        if self.last < 0:
            raise BadValue("last", self.last, "a whole number from 0")

    def recall(self, past: tuple[Turn, ...], task: Task, rng: np.random.Generator) -> tuple[Turn, ...]:
        """The newest exchanges."""
        return past[len(past) - self.last :] if self.last < len(past) else past
