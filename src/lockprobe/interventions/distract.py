"""The intervention ``distract``: an irrelevant sentence next to the report."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from lockprobe.interventions.luck import AtRandomSteps, hits
from lockprobe.trial.briefing import Briefing
from lockprobe.trial.record import Moment, Task

ASIDES = (
    "Note: the room in which the panel stands has a window.",
    "Note: the table under the panel is as wide as the panel.",
    "Note: somebody has put a cup of coffee beside the panel.",
    "Note: the panel was built in a workshop on the ground floor.",
    "Note: the labels of the joints are printed in dark letters.",
    "Note: a calendar with pictures of boats hangs on the wall.",
)
"""The irrelevant sentences: they say nothing about the joints and do not change the meaning of the report."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Distract(AtRandomSteps):
    """With probability p an irrelevant sentence comes with the report, which stays unchanged.

    Its moments are random, unlike those of ``remark``; the first step has none. Agents that read no words ignore it.
    What is said at a smaller p is said at a larger one too.
    """

    name: ClassVar[str] = "distract"

    def brief(self, briefing: Briefing, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Briefing:
        """The briefing with a sentence, or without."""
        said, which = rng.random(2)
        if len(past) < 2 or said >= self.p or not hits(self.at, len(past) - 1):
            return briefing
        return briefing.remarking(ASIDES[int(which * len(ASIDES))])
