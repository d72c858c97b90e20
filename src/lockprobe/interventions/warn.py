"""The intervention ``warn``: the instruction says that reports may be false."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from lockprobe.foundation.validation import check_probability
from lockprobe.trial.briefing import Briefing
from lockprobe.trial.record import Moment, Task


@dataclass(frozen=True, slots=True, kw_only=True)
class Warn:
    """The instruction warns that reports may be false, optionally with the rate; reports stay unchanged.

    Agents that read no words ignore it. Nothing is drawn.

    Attributes:
        rate: The rate of false reports that the instruction states, [0, 1]; None for "sometimes".

    Raises:
        BadValue: If it is no probability.
    """

    name: ClassVar[str] = "warn"
    rate: float | None = None

    def __post_init__(self) -> None:
        if self.rate is not None:
            check_probability("rate", self.rate)

    def brief(self, briefing: Briefing, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Briefing:
        """The briefing with the warning."""
        return briefing.warning_of(self.sentence)

    @property
    def sentence(self) -> str:
        """The sentence of the instruction."""
        often = "sometimes" if self.rate is None else f"with probability {self.rate:g}"
        return f"What you are told of your last action is {often} false."
