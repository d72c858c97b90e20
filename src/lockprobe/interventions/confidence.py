"""The intervention ``confidence``: the agent is asked how sure it is."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from lockprobe.foundation.errors import Conflict
from lockprobe.trial.briefing import Briefing
from lockprobe.trial.record import Moment, Task

__all__ = ["Confidence"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Confidence:
    """Asks a hosted model how sure it is of the effect of its last action, and whether it thinks the report false.

    The record holds its answers: ``confidence`` from 0 to 100, and ``report_false``. What it is told stays as it is,
    but the second question says that a report may be false. Other agents ignore it. Nothing is drawn.
    """

    name: ClassVar[str] = "confidence"
    draws: ClassVar[bool] = False

    def brief(self, briefing: Briefing, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Briefing:
        """The briefing with both questions.

        Raises:
            Conflict: If the agent is not asked what the last action did.
        """
        if not task.assessment:
            raise Conflict("confidence", "--no-assessment", "it asks how sure the agent is of its assessment")
        return replace(briefing, confidence=True)
