"""Interventions on what is told. They change the report, never the box."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Literal, get_args

import numpy as np

from lockprobe.errors import BadValue
from lockprobe.record import Moment, Outcome, Percept, Task

__all__ = ["FlipKind", "OutcomeFlip"]

FlipKind = Literal["transient", "sticky", "outcome-only"]


@dataclass(frozen=True, slots=True, kw_only=True)
class OutcomeFlip:
    """With probability ``p`` the agent is told the inverse of what its action did (paper, Sec. 3.2).

    The outcome in the report is inverted and so is the reported position of the attempted joint, so that the two
    agree. The inversion is relative to where the joint really was. The paper leaves open whether a false report
    persists; each reading is a choice of ``persistence``:

    * ``transient``: every report starts from the truth, only the attempted joint can be wrong in it.
    * ``sticky``: a false position stays in the reports until that joint is attempted again.
    * ``outcome-only``: the report holds the outcome and no positions.

    One number is drawn per attempt whatever ``p`` is, so the flips at a smaller ``p`` are a subset of those at a
    larger one. Above p = 0.5 the report is informative again, with its meaning inverted.

    Attributes:
        p: Flip probability, [0, 1].
        persistence: What becomes of a false report.

    Raises:
        BadValue: If ``p`` or ``persistence`` is none of these.
    """

    name: ClassVar[str] = "flip"
    dose: ClassVar[str] = "p"
    stream: ClassVar[str] = "channel"
    p: float = 0.0
    persistence: FlipKind = "transient"

    def __post_init__(self) -> None:
        if not 0.0 <= self.p <= 1.0:
            raise BadValue("flip rate p", self.p, "a number from 0 to 1")
        if self.persistence not in get_args(FlipKind):
            raise BadValue("flip", self.persistence, f"one of {', '.join(get_args(FlipKind))}")

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        """The percept with its outcome inverted, or not."""
        flipped = percept.joint is not None and rng.random() < self.p
        outcome: Outcome | None = percept.outcome
        if flipped:
            outcome = "blocked" if percept.outcome == "moved" else "moved"
        return replace(percept, outcome=outcome, positions=self._positions(percept, past, task, flipped))

    def _positions(
        self, percept: Percept, past: tuple[Moment, ...], task: Task, flipped: bool
    ) -> tuple[bool, ...] | None:
        if percept.positions is None or self.persistence == "outcome-only":
            return None
        believed = percept.positions
        if self.persistence == "sticky" and past and past[-1].reported.positions is not None:
            believed = past[-1].reported.positions
        return tuple(
            truth ^ flipped if label == percept.joint else earlier
            for label, truth, earlier in zip(task.joints, percept.positions, believed, strict=True)
        )
