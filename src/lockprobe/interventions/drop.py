"""The intervention ``drop``: missing reports."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from lockprobe.interventions.luck import AtRandomSteps, hits
from lockprobe.trial.record import Moment, Percept, Task


@dataclass(frozen=True, slots=True, kw_only=True)
class Drop(AtRandomSteps):
    """With probability p the report of an attempt is missing; the box and all other reports stay unchanged.

    The reports lost at a smaller p are lost at a larger one too.
    """

    name: ClassVar[str] = "drop"

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        """The percept, or an empty one."""
        if percept.joint is None or rng.random() >= self.p or not hits(self.at, len(past)):
            return percept
        return replace(percept, outcome=None, positions=None, corrects=None)
