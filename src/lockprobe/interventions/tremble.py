"""The intervention ``tremble``: another joint than the chosen one is attempted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from lockprobe.validation import check_probability

if TYPE_CHECKING:
    import numpy as np

    from lockprobe.record import Moment, Task

__all__ = ["Tremble"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Tremble:
    """With probability p another joint than the chosen one is attempted, each equally likely, and truthfully reported.

    Two numbers are drawn per step whatever p is, so the steps at which it slips at a smaller p are among those at a
    larger one.

    Attributes:
        p: Probability that another joint is attempted, [0, 1].

    Raises:
        BadValue: If it is none.
    """

    name: ClassVar[str] = "tremble"
    dose: ClassVar[str] = "p"
    p: float = 0.0

    def __post_init__(self) -> None:
        check_probability("tremble rate p", self.p)

    def act(self, joint: str, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> str:
        """The joint, or another one."""
        slips, which = rng.random(2)
        others = [label for label in task.joints if label != joint]
        return others[int(which * len(others))] if slips < self.p else joint
