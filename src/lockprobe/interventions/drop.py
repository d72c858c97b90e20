"""The intervention ``drop``: missing reports."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

from lockprobe.interventions.luck import Luck, check_luck, check_steps, hits, stream_of
from lockprobe.validation import check_probability

if TYPE_CHECKING:
    import numpy as np

    from lockprobe.record import Moment, Percept, Task

__all__ = ["Drop"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Drop:
    """With probability p nothing is told of an attempt; the box and all other reports stay as they are.

    One number is drawn per attempt whatever p is, so the reports lost at a smaller p are lost at a larger one too.

    Attributes:
        p: Probability that a report is lost, [0, 1].
        luck: Whose steps it hits: its own, or those at which ``flip`` lies at the same p.
        at: The steps whose reports can be lost; empty for all of them.

    Raises:
        BadValue: If a value is none of these.
    """

    name: ClassVar[str] = "drop"
    dose: ClassVar[str] = "p"
    later: ClassVar[tuple[str, ...]] = ("luck", "at")
    p: float = 0.0
    luck: Luck = "own"
    at: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        check_probability("drop rate p", self.p)
        check_luck(self.luck)
        check_steps(self.at)

    @property
    def stream(self) -> str:
        """The name of its random stream."""
        return stream_of(self.luck, type(self))

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        """The percept, or one that says nothing."""
        if percept.joint is None or rng.random() >= self.p or not hits(self.at, len(past)):
            return percept
        return replace(percept, outcome=None, positions=None)
