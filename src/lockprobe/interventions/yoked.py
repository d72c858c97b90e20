"""The intervention ``yoked``: false reports at the steps of another trial's flips."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal, get_args

import numpy as np

from lockprobe.foundation.validation import check_choice, check_probability
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.trial.luck import at_step
from lockprobe.trial.record import Moment, Percept, Task

How = Literal["next", "shuffle"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Yoked:
    """False reports at the steps at which ``flip`` lies in the next trial, or in this one in shuffled order.

    It has the dose of its source and is independent of the course of this trial. With ``next`` it has the luck of the
    next trial of the same repetition, step by step. With ``shuffle`` it has the luck of this trial at permuted steps:
    over the whole budget exactly as many reports are false as under ``flip``. A flip that depends on what happens
    (``only``, ``while``) has no steps in advance: what is yoked is its rate, not its lies. It draws nothing itself.

    Attributes:
        p: Flip probability of the source, [0, 1].
        how: Whose steps.

    Raises:
        BadValue: If a value is none of these.
    """

    name: ClassVar[str] = "yoked"
    doses: ClassVar[tuple[str, ...]] = ("p",)
    stream: ClassVar[str] = OutcomeFlip.stream
    always_tells: ClassVar[bool] = True
    p: float = 0.0
    how: How = "next"

    def __post_init__(self) -> None:
        check_probability("flip rate p", self.p)
        check_choice("how", self.how, get_args(How))

    @property
    def ahead(self) -> int:
        """How many trials after this one the trial is whose luck it has."""
        return 1 if self.how == "next" else 0

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        """The percept with its outcome inverted, or not."""
        if percept.joint is None:
            return percept
        if self.how == "next":
            return OutcomeFlip(p=self.p).perceive(percept, past, task, rng)
        step = 1 + int(at_step(rng, 0).permutation(task.budget)[len(past) - 1])
        return OutcomeFlip(p=self.p).perceive(percept, past, task, at_step(rng, step))
