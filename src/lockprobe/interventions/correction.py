"""The intervention ``correction``: reports that are corrected at once."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Literal, get_args

import numpy as np

from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.interventions.luck import check_steps, hits
from lockprobe.record import Moment, Outcome, Percept, Task
from lockprobe.validation import check_choice, check_probability

__all__ = ["Correction"]

Of = Literal["lie", "truth"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Correction:
    """With probability p a report is a lie that is corrected at once by the truth.

    It hits the steps at which ``flip`` lies at the same p, and leaves nothing false. With ``of=truth`` the first report
    is true as well: a placebo that measures the effect of a correction alone. Corrections are made in words; pictures
    cannot be corrected. One number is drawn per attempt whatever p is.

    Attributes:
        p: Probability that a report is corrected, [0, 1].
        of: What is said first.
        at: The steps whose reports can be corrected; empty for all of them.

    Raises:
        BadValue: If a value is none of these.
    """

    name: ClassVar[str] = "correction"
    doses: ClassVar[tuple[str, ...]] = ("p",)
    stream: ClassVar[str] = OutcomeFlip.stream
    p: float = 0.0
    of: Of = "lie"
    at: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        check_steps(self.at)
        check_probability("correction rate p", self.p)
        check_choice("of", self.of, get_args(Of))

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        """The percept, with what was said before it or without."""
        if percept.joint is None or rng.random() >= self.p or not hits(self.at, len(past)):
            return percept
        if self.of == "truth":
            return replace(percept, corrects=percept)
        return replace(percept, corrects=_inverted(percept, task))


def _inverted(percept: Percept, task: Task) -> Percept:
    """The lie that a memoryless flip tells."""
    positions = percept.positions
    if positions is not None:
        at = task.joints.index(str(percept.joint))
        positions = (*positions[:at], not positions[at], *positions[at + 1 :])
    outcome: Outcome | None = percept.outcome
    if outcome is not None:
        outcome = "blocked" if outcome == "moved" else "moved"
    return replace(percept, outcome=outcome, positions=positions)
