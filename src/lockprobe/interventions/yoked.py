"""The intervention ``yoked``: false reports at the steps of another trial's flips."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Literal, get_args

import numpy as np

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.validation import check_choice, check_probability
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.trial.record import Moment, Percept, Task

__all__ = ["How", "Yoked"]

How = Literal["next", "shuffle", "looping"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Yoked:
    """False reports at the steps at which ``flip`` lies in the next trial, or in this one in shuffled order.

    It has the dose of its source and is independent of the course of this trial. With ``next`` it has the luck of the
    next trial of the same repetition, step by step. With ``shuffle`` it has the luck of this trial at permuted steps:
    over the whole budget exactly as many reports are false as under ``flip``. A flip that depends on what happens
    (``only``, ``while``) has no steps in advance: what is yoked is its rate, not its lies. It draws nothing itself.

    With ``looping`` an agent is yoked to itself: it is told as many false reports as in its trial of equal luck under
    ``flip?p=…&while=looping``, at random steps of as many as that trial had. That trial has to be on record, so only a
    study with both conditions can play it (:mod:`lockprobe.studies.running.followers`).

    Attributes:
        p: Flip probability of the source, [0, 1].
        how: Whose steps.
        at: With ``looping`` the steps of the false reports, from 1, which the study fills in; 0 alone stands for none.

    Raises:
        BadValue: If a value is none of these.
    """

    name: ClassVar[str] = "yoked"
    doses: ClassVar[tuple[str, ...]] = ("p",)
    stream: ClassVar[str] = OutcomeFlip.stream
    always_tells: ClassVar[bool] = True
    implied: ClassVar[tuple[str, ...]] = ("at",)
    p: float = 0.0
    how: How = "next"
    at: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        check_probability("flip rate p", self.p)
        check_choice("how", self.how, get_args(How))
        if self.at and self.how != "looping":
            raise BadValue("at", self.at, f"no steps with how={self.how}")

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
        if self.how == "looping":
            if not self.at:
                source = f"flip?p={self.p:g}&while=looping"
                raise BadValue(
                    "condition", "yoked?how=looping", f"a study that also has {source}, whose trials it follows"
                )
            return OutcomeFlip(p=float(len(past) in self.at)).perceive(percept, past, task, rng)
        seed: Any = rng.bit_generator.seed_seq
        anew = np.random.Generator(type(rng.bit_generator)(seed))
        lies = anew.random(task.budget) < self.p
        false = lies[anew.permutation(task.budget)[len(past) - 1]]
        return OutcomeFlip(p=float(false)).perceive(percept, past, task, rng)
