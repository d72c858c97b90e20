"""The intervention ``delay``: reports that come late."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from lockprobe.foundation.errors import BadValue
from lockprobe.trial.record import Moment, Percept, Task


@dataclass(frozen=True, slots=True, kw_only=True)
class Delay:
    """Every report is late: it tells the truth of ``lag`` attempts ago, and names the joint attempted then.

    Until the first late report nothing is told. Each report starts from the truth, so changes by earlier interventions
    are lost. Nothing is drawn.

    Attributes:
        lag: Attempts by which a report is late, from 0.

    Raises:
        BadValue: If it is negative.
    """

    name: ClassVar[str] = "delay"
    doses: ClassVar[tuple[str, ...]] = ("lag",)
    lag: int = 1

    def __post_init__(self) -> None:
        if self.lag < 0:
            raise BadValue("lag", self.lag, "a whole number from 0")

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        """The percept of some attempts ago."""
        if percept.joint is None or self.lag == 0:
            return percept
        if len(past) - self.lag < 1:  # the first look is no report of an attempt
            return replace(percept, joint=None, outcome=None, positions=None, corrects=None)
        late = past[len(past) - self.lag].was
        return replace(percept, joint=late.joint, outcome=late.outcome, positions=late.positions, corrects=None)
