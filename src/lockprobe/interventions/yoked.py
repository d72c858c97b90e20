"""The intervention ``yoked``: false reports at the steps of another trial's flips."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal, get_args

import numpy as np

from lockprobe.errors import BadValue
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.validation import check_probability

if TYPE_CHECKING:
    from lockprobe.record import Moment, Percept, Task

__all__ = ["How", "Yoked"]

How = Literal["next", "shuffle"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Yoked:
    """False reports at the steps at which ``flip`` at the same p lies in the next trial, or in this one in other order.

    It has the dose of its source and nothing to do with what this trial came to: at ``next`` it has the luck of the
    next trial of the same repetition, step by step; at ``shuffle`` this trial's own, with its steps in an order that
    is drawn once, so that over the whole budget exactly as many reports are false as under ``flip``. A flip that
    depends on what happens (``only``, ``while``) has no steps before it is played: yoked to one are its chances, not
    its lies. It draws nothing itself.

    Attributes:
        p: Flip probability of the source, [0, 1].
        how: Whose steps.

    Raises:
        BadValue: If a value is none of these.
    """

    name: ClassVar[str] = "yoked"
    dose: ClassVar[str] = "p"
    stream: ClassVar[str] = OutcomeFlip.stream
    p: float = 0.0
    how: How = "next"

    def __post_init__(self) -> None:
        check_probability("flip rate p", self.p)
        if self.how not in get_args(How):
            raise BadValue("how", self.how, f"one of {', '.join(get_args(How))}")

    @property
    def ahead(self) -> int:
        """By how many trials ahead of this one the trial is whose luck it has."""
        return 1 if self.how == "next" else 0

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        """The percept with its outcome inverted, or not."""
        if percept.joint is None:
            return percept
        if self.how == "next":
            return OutcomeFlip(p=self.p).perceive(percept, past, task, rng)
        seed: Any = rng.bit_generator.seed_seq
        anew = np.random.Generator(type(rng.bit_generator)(seed))
        lies = anew.random(task.budget) < self.p
        false = lies[anew.permutation(task.budget)[len(past) - 1]]
        return OutcomeFlip(p=float(false)).perceive(percept, past, task, rng)
