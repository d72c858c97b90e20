"""The intervention ``confidence``: the agent is asked how sure it is."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from lockprobe.errors import BadValue
from lockprobe.record import Briefing, Moment, Task

__all__ = ["Confidence"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Confidence:
    """A hosted model is asked how sure it is of what its last action did, and whether it thinks the report false.

    The record holds its answers: ``confidence`` from 0 to 100, and ``report_false``. What it is told stays as it is,
    but the second question says that a report may be false. Other agents ignore it. Nothing is drawn.
    """

    name: ClassVar[str] = "confidence"

    def brief(self, briefing: Briefing, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Briefing:
        """The briefing with both questions.

        Raises:
            BadValue: If nobody asks what the last action did.
        """
        if not task.assessment:
            raise BadValue("confidence", "no assessment", "agents that are asked what their last action did")
        return replace(briefing, confidence=True)
