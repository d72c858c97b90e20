"""Which steps an intervention hits: drawn independently, those at which ``flip`` would lie, or only given ones."""

from __future__ import annotations

from typing import Literal, get_args

from lockprobe.errors import BadValue
from lockprobe.interventions.flip import OutcomeFlip

__all__ = ["Luck", "check_luck", "check_steps", "hits", "stream_of", "within"]

Luck = Literal["own", "flip"]
"""With ``flip`` one number per attempt comes from the stream of the flip: equal doses hit equal steps."""


def check_luck(luck: str) -> None:
    """Refuses what is none.

    Raises:
        BadValue: If it is neither.
    """
    if luck not in get_args(Luck):
        raise BadValue("luck", luck, f"one of {', '.join(get_args(Luck))}")


def stream_of(luck: Luck, kind: type[object]) -> str:
    """The name of the random stream of a class of interventions."""
    return OutcomeFlip.stream if luck == "flip" else kind.__name__


def within(number: float, p: float) -> float:
    """Where in its interval a number lies that has hit, [0, 1): a second draw from the same number.

    >>> within(0.1, 0.4)
    0.25
    """
    return number / p


def check_steps(at: tuple[int, ...]) -> None:
    """Refuses steps that no trial has.

    Raises:
        BadValue: If one is below 1.
    """
    for step in at:
        if step < 1:
            raise BadValue("at", step, "a step from 1")


def hits(at: tuple[int, ...], step: int) -> bool:
    """Whether an intervention that is limited to the steps ``at`` can act at this one; without steps at any."""
    return not at or step in at
