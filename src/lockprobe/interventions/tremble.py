"""The intervention ``tremble``: another joint than the chosen one is attempted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from lockprobe.interventions.luck import Luck, check_luck, check_steps, hits, stream_of, within
from lockprobe.validation import check_probability

if TYPE_CHECKING:
    import numpy as np

    from lockprobe.record import Moment, Task

__all__ = ["Tremble"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Tremble:
    """With probability p another joint than the chosen one is attempted, each equally likely, and truthfully reported.

    Two numbers are drawn per step whatever p is (one with ``luck=flip``), so the steps at which it slips at a
    smaller p are among those at a larger one.

    Attributes:
        p: Probability that another joint is attempted, [0, 1].
        luck: Whose steps it hits: its own, or those at which ``flip`` lies at the same p.
        at: The steps at which it can slip; empty for all of them.

    Raises:
        BadValue: If a value is none of these.
    """

    name: ClassVar[str] = "tremble"
    dose: ClassVar[str] = "p"
    later: ClassVar[tuple[str, ...]] = ("luck", "at")
    p: float = 0.0
    luck: Luck = "own"
    at: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        check_probability("tremble rate p", self.p)
        check_luck(self.luck)
        check_steps(self.at)

    @property
    def stream(self) -> str:
        """The name of its random stream."""
        return stream_of(self.luck, type(self))

    def act(self, joint: str, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> str:
        """The joint, or another one."""
        if self.luck == "flip":
            slips = rng.random()
            which = within(slips, self.p) if slips < self.p else 0.0
        else:
            slips, which = rng.random(2)
        others = [label for label in task.joints if label != joint]
        return others[int(which * len(others))] if slips < self.p and hits(self.at, len(past)) else joint
