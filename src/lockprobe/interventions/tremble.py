"""The intervention ``tremble``: another joint than the chosen one is attempted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from lockprobe.interventions.luck import AtRandomSteps, hits
from lockprobe.trial.record import Moment, Task


@dataclass(frozen=True, slots=True, kw_only=True)
class Tremble(AtRandomSteps):
    """With probability p a random other joint is attempted instead of the chosen one, and reported truthfully.

    The steps at which it slips at a smaller p are among those at a larger one.
    """

    name: ClassVar[str] = "tremble"

    def act(self, joint: str, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> str:
        """The joint, or another one."""
        slips, which = rng.random(2)
        others = [label for label in task.joints if label != joint]
        return others[int(which * len(others))] if slips < self.p and hits(self.at, len(past)) else joint
