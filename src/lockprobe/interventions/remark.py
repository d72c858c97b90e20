"""The intervention ``remark``: an empty sentence, as the control of ``nudge``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from lockprobe.foundation.errors import BadValue
from lockprobe.interventions.nudge import loops_completed
from lockprobe.trial.briefing import Briefing
from lockprobe.trial.record import Moment, Task

REMARK = "Note: this panel is made of wood, and its surface is painted in a light grey."
"""A sentence as long as the nudge, without information."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Remark:
    """The control of ``nudge``: at the same moments, a sentence of equal length without information.

    The report stays as it is. Agents that read no words ignore it. Nothing is drawn.

    Attributes:
        after: Copies of a loop after which it is said, from 2; 0 for before every step but the first.

    Raises:
        BadValue: If it is none of these.
    """

    name: ClassVar[str] = "remark"
    after: int = 2

    def __post_init__(self) -> None:
        if self.after < 0 or self.after == 1:
            raise BadValue("after", self.after, "a number of copies from 2, or 0 for always")

    def brief(self, briefing: Briefing, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Briefing:
        """The briefing with the sentence, where it is due."""
        if not (len(past) > 1 if self.after == 0 else loops_completed(past, self.after)):
            return briefing
        return briefing.remarking(REMARK)
