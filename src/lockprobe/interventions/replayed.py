"""The intervention ``yoked?claims=…``: the misreadings of another trial, told as false reports."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar, Literal, NamedTuple, TypeVar, get_args

import numpy as np

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.validation import check_choice, check_probability
from lockprobe.interventions.flip import Inverts, OutcomeFlip
from lockprobe.trial.record import Moment, Outcome, Percept, Task

__all__ = ["NOTHING", "Misreading", "Order", "Replayed", "misreading_entry"]

Order = Literal["same", "shuffle"]

_T = TypeVar("_T")

NOTHING = ("none",)
"""The misreadings of a trial in which nothing was misread."""


class Misreading(NamedTuple):
    """A misreading of the source trial: its step, the label of the joint, and what the attempt really did."""

    step: int
    joint: str
    outcome: Outcome


def misreading_entry(found: Misreading) -> str:
    """A misreading as an option holds it.

    >>> misreading_entry(Misreading(4, "B", "moved"))
    '4:B:moved'
    """
    return ":".join(map(str, found))


@dataclass(frozen=True, slots=True, kw_only=True)
class Replayed:
    """False reports that repeat the misreadings of another trial: of the same agent, with the same luck.

    The source trial is of the condition ``claims``, usually pictures. Where its agent misread what an attempt did, this
    trial has a false report of the opposite outcome. If what the agent does depends on its misreadings alone, both
    trials are equal. If they part, a misreading waits for the next attempt of its joint with its outcome, so that joint
    and direction stay and only the step is later; one that finds none is not told.

    With ``how=shuffle`` as many reports are false as were misread, at random steps of as many as the source trial had,
    whatever joint is attempted.

    ``claims=CONDITION`` is a condition of the same study; ``claims=STUDY/CONDITION`` is one of another study, by its
    directory, with the trial of the same repetition and number; it has the same luck if that study has the same seed.
    The record holds the misreadings. It draws nothing.

    Attributes:
        p: Share of the misreadings that is told, [0, 1]; those at a smaller p are a subset of those at a larger one.
        claims: The condition of the source trial, by its label.
        of: The agent of the other study; empty for the agent that plays, or the only one there.
        digest: Of another study, the hash of its misreadings, which the study fills in, so that a changed source is
            refused.
        how: One by one, or as many at random steps.
        inverts: What a false report inverts, as for ``flip``.
        others: What becomes of the false positions of other joints, as for ``flip``.
        misread: The misreadings, one by one, which the study fills in: step, label, true outcome; ``none`` for none.
        at: With ``shuffle``, the steps of the false reports, which the study fills in; 0 alone stands for none.

    Raises:
        BadValue: If a value is none of these.
    """

    name: ClassVar[str] = "yoked"
    variant: ClassVar[str] = "claims"
    doses: ClassVar[tuple[str, ...]] = ("p",)
    stream: ClassVar[str] = OutcomeFlip.stream
    always_tells: ClassVar[bool] = True
    implied: ClassVar[tuple[str, ...]] = ("misread", "at")
    p: float = 1.0
    claims: str = ""
    of: str = ""
    digest: str = ""
    how: Order = "same"
    inverts: Inverts = "outcome"
    others: Literal["fresh", "kept"] = "fresh"
    misread: tuple[str, ...] = ()
    at: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        check_probability("p", self.p)
        check_choice("how", self.how, get_args(Order))
        if not self.claims:
            raise BadValue("claims", self.claims, "CONDITION of this study, or STUDY/CONDITION")
        _read(self.misread)
        self._flip(flipped=False)

    def _flip(self, *, flipped: bool) -> OutcomeFlip:
        return OutcomeFlip(p=float(flipped), inverts=self.inverts, others=self.others)

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        """The percept with its outcome inverted, or not.

        Raises:
            BadValue: If no study has filled the misreadings in.
        """
        if percept.joint is None or not self.p:
            return self._flip(flipped=False).perceive(percept, past, task, rng)
        if not (self.misread or self.at):
            raise BadValue("condition", f"yoked?claims={self.claims}", "a study that has it: it follows its trials")
        falls = len(past) in self._kept(self.at, rng) if self.how == "shuffle" else self._due(percept, past, rng)
        return self._flip(flipped=falls).perceive(percept, past, task, rng)

    def _due(self, percept: Percept, past: tuple[Moment, ...], rng: np.random.Generator) -> bool:
        """Whether a misreading is told now: one of this joint and outcome whose step has come and that waits."""
        waiting = [*self._kept(_read(self.misread), rng)]
        for step, moment in enumerate(past[1:], 1):
            _take(waiting, step, moment.was)
        return _take(waiting, len(past), percept)

    def _kept(self, found: tuple[_T, ...], rng: np.random.Generator) -> tuple[_T, ...]:
        """The share ``p`` of what is told, drawn anew from the beginning of the stream at every report."""
        if self.p == 1:
            return found
        seed: Any = rng.bit_generator.seed_seq
        drawn = np.random.Generator(type(rng.bit_generator)(seed)).random(len(found))
        return tuple(one for one, number in zip(found, drawn, strict=True) if number < self.p)


def _take(waiting: list[Misreading], step: int, percept: Percept) -> bool:
    """Take the first misreading of this joint and outcome, if its step has come."""
    for one in waiting:
        if one.step <= step and (one.joint, one.outcome) == (percept.joint, percept.outcome):
            waiting.remove(one)
            return True
    return False


@cache
def _read(entries: tuple[str, ...]) -> tuple[Misreading, ...]:
    """The misreadings that entries describe.

    Raises:
        BadValue: If an entry is none.
    """
    found = []
    for entry in () if entries == NOTHING else entries:
        step, _, rest = entry.partition(":")
        joint, _, outcome = rest.rpartition(":")
        if not step.isdecimal() or not joint or outcome not in get_args(Outcome):
            raise BadValue("misread", entry, "step, joint and true outcome, such as 4:B:moved")
        found.append(Misreading(int(step), joint, outcome))  # type: ignore[arg-type]  # checked above
    return tuple(found)
