"""The intervention ``hypothesis``: the agent says how the box works before or after it chooses, or never."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, get_args

import numpy as np

from lockprobe.foundation.validation import check_choice
from lockprobe.trial.briefing import Ask, Briefing
from lockprobe.trial.record import Moment, Task


@dataclass(frozen=True, slots=True, kw_only=True)
class Hypothesis:
    """Asks a hosted model for one sentence on how the box works, before or after it names a joint, or never.

    ``before`` is the default for every hosted model: a short chain of thought; ``--hypothesis`` sets another one for a
    whole study. Reports stay unchanged. Other agents ignore it. Nothing is drawn.

    Attributes:
        ask: When it is asked.

    Raises:
        BadValue: If it is none of these.
    """

    name: ClassVar[str] = "hypothesis"
    ask: Ask = "before"

    def __post_init__(self) -> None:
        check_choice("ask", self.ask, get_args(Ask))

    def brief(self, briefing: Briefing, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Briefing:
        """The briefing with when it is asked."""
        return replace(briefing, hypothesis=self.ask)
