"""The steps that an intervention hits: random ones, those at which ``flip`` would lie, or only given ones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal, get_args

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.validation import check_choice, check_probability
from lockprobe.interventions.flip import OutcomeFlip

Luck = Literal["own", "flip"]
"""With ``flip`` the numbers come from the stream of the flip: equal doses hit equal steps."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AtRandomSteps:
    """An intervention that hits each step with probability p.

    Attributes:
        p: Probability that a step is hit, [0, 1].
        luck: Which steps are hit: random steps of this intervention, or those at which ``flip`` lies at the same p.
        at: The steps that can be hit; empty for all of them.

    Raises:
        BadValue: If a value is none of these.
    """

    name: ClassVar[str]
    doses: ClassVar[tuple[str, ...]] = ("p",)
    p: float = 0.0
    luck: Luck = "own"
    at: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        check_probability(f"{self.name} rate p", self.p)
        check_choice("luck", self.luck, get_args(Luck))
        check_steps(self.at)

    @property
    def stream(self) -> str:
        """The name of its random stream."""
        return OutcomeFlip.stream if self.luck == "flip" else type(self).__name__


def check_steps(at: tuple[int, ...]) -> None:
    """Refuse steps that no trial has.

    Raises:
        BadValue: If one is below 1.
    """
    for step in at:
        if step < 1:
            raise BadValue("at", step, "a step from 1")


def hits(at: tuple[int, ...], step: int) -> bool:
    """Whether an intervention limited to the steps ``at`` can act at this step; empty ``at`` allows all."""
    return not at or step in at
