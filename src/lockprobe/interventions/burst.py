"""The intervention ``burst``: false reports that come in runs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.validation import check_probability
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.trial.record import Moment, Percept, Task

__all__ = ["Burst"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Burst:
    """False reports in runs: as many as with ``flip`` at the same p, but a false report often follows another.

    True and false reports form a two-state Markov chain with a share p of false ones from the first report on and a
    mean run length of ``length``. Reports one step apart have the correlation ``1 - 1/length - p/(length (1 - p))``;
    at ``length = 1/(1 - p)`` they are independent. Two numbers are drawn per attempt.

    Attributes:
        p: Share of false reports, [0, 1), at most ``length / (length + 1)``.
        length: Mean length of a run of false reports, from 1.

    Raises:
        BadValue: If a number is out of range.
    """

    name: ClassVar[str] = "burst"
    doses: ClassVar[tuple[str, ...]] = ("p", "length")
    always_tells: ClassVar[bool] = True
    p: float = 0.0
    length: float = 3.0

    def __post_init__(self) -> None:
        check_probability("flip rate p", self.p)
        if not 1 <= self.length < float("inf"):
            raise BadValue("length", self.length, "a number from 1")
        most = self.length / (self.length + 1)
        if self.p > most:
            raise BadValue("flip rate p", self.p, f"at most {most:g} in runs of {self.length:g}")

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        """The percept with its outcome inverted, or not."""
        if percept.joint is None:
            return percept
        false = rng.random() < self._chance(past)
        return OutcomeFlip(p=float(false)).perceive(percept, past, task, rng)

    def _chance(self, past: tuple[Moment, ...]) -> float:
        """The probability that the next report is false, given whether the last one was."""
        if len(past) < 2:
            return self.p
        last = past[-1]
        if last.reported.outcome is not None and last.reported.outcome != last.was.outcome:
            return 1 - 1 / self.length
        return self.p / (self.length * (1 - self.p))
