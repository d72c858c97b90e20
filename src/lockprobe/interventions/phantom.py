"""The intervention ``phantom``: a joint that was not attempted seems to jump, and seems to come back."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

from lockprobe.foundation.validation import check_probability
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.trial.record import Moment, Percept, Task

if TYPE_CHECKING:
    import numpy as np


@dataclass(frozen=True, slots=True, kw_only=True)
class Phantom:
    """With probability p a report tells a false position of one joint that was not attempted.

    Each of the other joints is equally likely. The next report tells its true position again, unless a flip keeps false
    positions, and no told outcome is changed: so a phantom has what a false report has, a false position and its
    correction, without the false outcome. It hits the steps at which ``flip`` lies at the same p. Where reports tell no
    outcomes, an agent that compares two reports is misled if it attempts the very joint next.

    The phantoms at a smaller p are a subset of those at a larger one.

    Attributes:
        p: Probability that a report has a phantom, [0, 1].

    Raises:
        BadValue: If it is no probability.
    """

    name: ClassVar[str] = "phantom"
    doses: ClassVar[tuple[str, ...]] = ("p",)
    stream: ClassVar[str] = OutcomeFlip.stream
    always_tells: ClassVar[bool] = True
    p: float = 0.0

    def __post_init__(self) -> None:
        check_probability("phantom rate p", self.p)

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        """The percept with the position of another joint inverted, or not."""
        if percept.joint is None:
            return percept
        (drawn, which), positions = rng.random(2), percept.positions
        others = [place for place, label in enumerate(task.joints) if label != percept.joint]
        if drawn >= self.p or positions is None or not others:
            return percept
        jumps = others[int(which * len(others))]
        told = tuple(position ^ (place == jumps) for place, position in enumerate(positions))
        return replace(percept, positions=told)
