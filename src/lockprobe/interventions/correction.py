"""The intervention ``correction``: reports in two statements, of which the second corrects the first."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Literal, get_args

import numpy as np

from lockprobe.foundation.validation import check_choice, check_probability
from lockprobe.interventions.flip import Inverts, OutcomeFlip
from lockprobe.interventions.luck import check_steps, hits
from lockprobe.trial.record import Moment, Percept, Task

Says = Literal["lie", "truth"]
"""What a statement says: a false report, or the true one."""

Others = Literal["fresh", "kept"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Correction:
    """With probability p a report is made of two statements: the first, and with the word "Correction" the last.

    It hits the steps at which ``flip`` lies at the same p. The four combinations have one form and differ in what they
    say: a lie that the truth corrects (the default), a truth that is repeated, a truth that a lie "corrects", and a lie
    that is repeated. A lie is the false report that ``flip`` tells, and later reports agree with the last statement.
    Corrections are made in words; pictures cannot be corrected.

    Attributes:
        p: Probability that a report is corrected, [0, 1].
        first: What the first statement says.
        last: What the last statement says.
        inverts: What a lie inverts, as in ``flip``.
        others: What becomes of the false positions of other joints, as in ``flip``.
        at: The steps whose reports can be corrected; empty for all of them.

    Raises:
        BadValue: If a value is none of these.
    """

    name: ClassVar[str] = "correction"
    doses: ClassVar[tuple[str, ...]] = ("p",)
    stream: ClassVar[str] = OutcomeFlip.stream
    always_tells: ClassVar[bool] = True
    p: float = 0.0
    first: Says = "lie"
    last: Says = "truth"
    inverts: Inverts = "outcome"
    others: Others = "fresh"
    at: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        check_steps(self.at)
        check_probability("correction rate p", self.p)
        for statement in ("first", "last"):
            check_choice(statement, getattr(self, statement), get_args(Says))
        check_choice("others", self.others, get_args(Others))
        self.lies  # noqa: B018  checks what it inverts

    @property
    def lies(self) -> OutcomeFlip:
        """The flip whose false reports its lies are."""
        return OutcomeFlip(p=self.p, inverts=self.inverts, others=self.others)

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        """The percept as its last statement tells it, with the first one if it is corrected."""
        if percept.joint is None:
            return percept
        hit = rng.random() < self.p and hits(self.at, len(past))
        first, last = (self._said(says, percept, past, task, hit=hit) for says in (self.first, self.last))
        return replace(last, corrects=first) if hit else last

    def _said(self, says: Says, percept: Percept, past: tuple[Moment, ...], task: Task, *, hit: bool) -> Percept:
        """What a statement tells; where the last one is true, nothing that was told stays false."""
        if self.last == says == "truth":
            return percept
        return self.lies.told(percept, past, task, flipped=hit and says == "lie", lasting=-int(self.lies.keep))
