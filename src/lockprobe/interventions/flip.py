"""The intervention ``flip``: false reports, the noise of the paper (Sec. 3.2). The box stays as it is."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar, Literal, get_args

from lockprobe.errors import BadValue
from lockprobe.record import Moment, Outcome, Percept, Task
from lockprobe.validation import check_choice, check_probability

if TYPE_CHECKING:  # the options of a study rest on this module, and their help needs no arithmetic
    import numpy as np

__all__ = ["FlipKind", "OutcomeFlip"]

FlipKind = Literal["transient", "sticky", "outcome-only"]

Only = Literal["moved", "blocked", "any"]
While = Literal["looping", "always"]


@dataclass(frozen=True, slots=True, kw_only=True)
class OutcomeFlip:
    """With probability ``p`` the report says the opposite of what the action did (paper, Sec. 3.2).

    The outcome in the report is inverted and so is the reported position of the attempted joint, so that the two
    agree. The inversion is relative to where the joint really was. The paper leaves open whether a false report
    persists; each reading is a choice of ``persistence``:

    * ``transient``: every report starts from the truth, only the attempted joint can be wrong in it.
    * ``sticky``: a false position stays in the reports until that joint is attempted again.
    * ``outcome-only``: the report holds the outcome and no positions.

    One number is drawn per attempt whatever the options are, so the flips at a smaller ``p`` are a subset of those at a
    larger one, and options only leave some of them out. Above p = 0.5 the report is informative again, with its
    meaning inverted. A report that says nothing is not inverted.

    Attributes:
        p: Flip probability, [0, 1].
        persistence: What becomes of a false report.
        only: Which outcomes are inverted.
        from_: The first step, from 1, whose report can be inverted; None for the first of all.
        until: The last one; None for the last of all.
        at: The steps whose reports can be inverted; empty for all of them. In a spec: ``at=4;8``.
        while_: With ``looping`` only a report is inverted whose attempt continues an action loop: the last three
            attempts, this one among them, have stood in this order before.

    Raises:
        BadValue: If a value is none of these.
    """

    name: ClassVar[str] = "flip"
    doses: ClassVar[tuple[str, ...]] = ("p",)
    stream: ClassVar[str] = "channel"
    p: float = 0.0
    persistence: FlipKind = "transient"
    only: Only = "any"
    from_: int | None = None
    until: int | None = None
    at: tuple[int, ...] = ()
    while_: While = "always"

    def __post_init__(self) -> None:
        check_probability("flip rate p", self.p)
        check_choice("flip", self.persistence, get_args(FlipKind))
        check_choice("only", self.only, get_args(Only))
        check_choice("while", self.while_, get_args(While))
        for what, step in (("from", self.from_), ("until", self.until), *(("at", step) for step in self.at)):
            if step is not None and step < 1:
                raise BadValue(what, step, "a step from 1")
        if self.until is not None and self.until < (self.from_ or 1):
            raise BadValue("until", self.until, f"a step from {self.from_}, the first step of the flip")

    def falls_on(self, step: int) -> bool:
        """Whether the report of this step, from 1, can be inverted."""
        return (
            (self.from_ is None or step >= self.from_)
            and (self.until is None or step <= self.until)
            and (not self.at or step in self.at)
        )

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        """The percept with its outcome inverted, or not."""
        flipped = percept.joint is not None and rng.random() < self.p and self._may(percept, past)
        outcome: Outcome | None = percept.outcome
        if flipped:
            outcome = "blocked" if percept.outcome == "moved" else "moved"
        return replace(percept, outcome=outcome, positions=self._positions(percept, past, task, flipped))

    def _may(self, percept: Percept, past: tuple[Moment, ...]) -> bool:
        if percept.outcome is None or self.only not in ("any", percept.outcome) or not self.falls_on(len(past)):
            return False
        return self.while_ == "always" or _continues_a_loop((*(was.attempted for was in past[1:]), percept.joint))

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


def _continues_a_loop(attempted: tuple[str | None, ...]) -> bool:
    """Whether the last three attempts have stood in this order before (a loop: three or more, paper, Sec. 3.3)."""
    before, last = attempted[:-3], attempted[-3:]
    return any(before[i : i + 3] == last for i in range(len(before) - 2))
