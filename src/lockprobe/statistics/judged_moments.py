"""What an observer believes at one moment of a trial, and what each attempt is worth then.

Many trials pass through equal beliefs, so a moment is one object, which knows those that follow it.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from lockprobe.boxes.beliefs.planning import all_expected_steps, all_information, least
from lockprobe.boxes.beliefs.posterior import Belief, ReportedAttempt, entropy, opened, update
from lockprobe.foundation.grouping import grouped

__all__ = ["MANY", "JudgedMoment", "Worth", "moment", "weigh"]

MANY = 1 << 14
"""Moments that are cached; each takes a few kilobytes."""

_TOGETHER = 64
"""Moments at which attempts are weighed at once."""

_NOTHING = 1e-9
"""Expected information below which an attempt counts as uninformative, bits."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Worth:
    """The value of each attempt to an observer; tuples hold one value for each of the n joints.

    Attributes:
        bits: Expected information, bits.
        best, optimal, regret, uninformative, by_chance: As in :class:`lockprobe.statistics.rationality.JudgedStep`.
    """

    bits: tuple[float, ...]
    best: float
    optimal: tuple[bool, ...]
    regret: tuple[float, ...]
    uninformative: tuple[bool, ...]
    by_chance: Mapping[str, float]


class JudgedMoment:
    """A belief of an observer with its consequences, each computed once."""

    def __init__(self, belief: Belief) -> None:
        self.belief = belief
        self._after: dict[ReportedAttempt | None, tuple[JudgedMoment, int]] = {}

    @cached_property
    def entropy(self) -> float:
        """Entropy over interlocks, in bits, >= 0."""
        return entropy(self.belief)

    @cached_property
    def worth(self) -> Worth:
        """The value of each attempt."""
        return _worths([self.belief])[0]

    def after(self, report: ReportedAttempt | None) -> tuple[JudgedMoment, int]:
        """The moment after a report, or after the box has opened (None), and the restarts of the observer."""
        found = self._after.get(report)
        if found is None:
            belief = opened(self.belief) if report is None else update(self.belief, report)
            again = belief.restarts - self.belief.restarts
            # Scaled weights of equal beliefs differ in their last digits.
            scaled = report is None or (again and report.joint == 0)
            found = self._after[report] = (JudgedMoment if scaled else moment)(belief), again
        return found


def weigh(moments: Iterable[JudgedMoment]) -> None:
    """Compute what each attempt is worth at all these moments, where it was not: together it takes less time."""
    new = [one for one in dict.fromkeys(moments) if "worth" not in vars(one)]
    for alike in grouped(new, lambda one: (one.belief.interlocks, one.belief.noise)).values():
        for i in range(0, len(alike), _TOGETHER):
            some = alike[i : i + _TOGETHER]
            for one, worth in zip(some, _worths([one.belief for one in some]), strict=True):
                one.worth = worth


def _worths(beliefs: Sequence[Belief]) -> list[Worth]:
    """The value of each attempt under beliefs of one prior and one model of reports."""
    bits, steps = all_information(beliefs), all_expected_steps(beliefs)
    optimal, regret, uninformative = least(steps), steps - steps.min(axis=1, keepdims=True), bits <= _NOTHING
    uninformative[:, 0] &= [not belief.weights @ belief.interlocks.moves(belief.configuration, 0) for belief in beliefs]
    each = {"expected": bits, "optimal": optimal, "regret": regret, "uninformative": uninformative}
    chances = zip(*((found.sum(axis=1) / found.shape[1]).tolist() for found in each.values()), strict=True)
    by_chance = [dict(zip(each, means, strict=True)) for means in chances]
    columns = (found.tolist() for found in (bits, bits.max(axis=1), optimal, regret, uninformative))
    return [
        Worth(
            bits=tuple(bits),
            best=best,
            optimal=tuple(optimal),
            regret=tuple(regret),
            uninformative=tuple(uninformative),
            by_chance=by_chance,
        )
        for bits, best, optimal, regret, uninformative, by_chance in zip(*columns, by_chance, strict=True)
    ]


_moments: dict[Hashable, JudgedMoment] = {}


def moment(belief: Belief) -> JudgedMoment:
    """The moment of a belief, the same object for equal beliefs.

    Once there are :data:`MANY`, all are forgotten, since each holds its successors.
    """
    if len(_moments) >= MANY:
        _moments.clear()
    return _moments.setdefault(belief.key, JudgedMoment(belief))
