"""The intervention ``drop``: missing reports."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

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

    Raises:
        BadValue: If it is none.
    """

    name: ClassVar[str] = "drop"
    dose: ClassVar[str] = "p"
    p: float = 0.0

    def __post_init__(self) -> None:
        check_probability("drop rate p", self.p)

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        """The percept, or one that says nothing."""
        if percept.joint is None or rng.random() >= self.p:
            return percept
        return replace(percept, outcome=None, positions=None)
