"""What an ideal observer knows, moment by moment, each worked out once however many trials come by."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, cached_property

from lockprobe.beliefs.planning import expected_steps, information, least
from lockprobe.beliefs.posterior import Belief, ReportedAttempt, entropy, opened, update

__all__ = ["MANY", "JudgedMoment", "Worth", "moment"]

MANY = 1 << 14
"""Moments that are remembered; each takes a few kilobytes."""

_NOTHING = 1e-9
"""Bits below which an attempt tells nothing."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Worth:
    """What each attempt is worth to an observer, a value for each of the n joints.

    Attributes:
        bits: Expected bits that it gives.
        best: The most of them.
        optimal: Whether no other costs fewer expected steps.
        regret: Expected steps that it costs more than the best.
        uninformative: Whether it can neither tell anything nor open the box.
        by_chance: ``expected``, ``optimal``, ``regret`` and ``uninformative`` of a random choice.
    """

    bits: tuple[float, ...]
    best: float
    optimal: tuple[bool, ...]
    regret: tuple[float, ...]
    uninformative: tuple[bool, ...]
    by_chance: Mapping[str, float]


class JudgedMoment:
    """What an observer knows at one moment, and what follows from it.

    Args:
        belief: What it knows.
    """

    def __init__(self, belief: Belief) -> None:
        self._belief = belief
        self._after: dict[ReportedAttempt | None, tuple[JudgedMoment, int]] = {}

    @cached_property
    def entropy(self) -> float:
        """How much is unknown of the interlock, in bits, from 0."""
        return entropy(self._belief)

    @cached_property
    def worth(self) -> Worth:
        """What each attempt is worth."""
        belief = self._belief
        bits, steps = information(belief), expected_steps(belief)
        optimal, regret, uninformative = least(steps), steps - steps.min(), bits <= _NOTHING
        uninformative[0] &= not belief.weights @ belief.interlocks.may_move(belief.configuration)[:, 0]
        values = {"expected": bits, "optimal": optimal, "regret": regret, "uninformative": uninformative}
        return Worth(
            bits=tuple(bits.tolist()),
            best=float(bits.max()),
            optimal=tuple(optimal.tolist()),
            regret=tuple(regret.tolist()),
            uninformative=tuple(uninformative.tolist()),
            by_chance={name: float(found.sum()) / len(bits) for name, found in values.items()},
        )

    def after(self, report: ReportedAttempt | None) -> tuple[JudgedMoment, int]:
        """What is known after a report, or after the box has opened, and how often the observer had to begin again."""
        found = self._after.get(report)
        if found is None:
            belief = opened(self._belief) if report is None else update(self._belief, report)
            again = belief.restarts - self._belief.restarts
            # Where weights are scaled from others, beliefs that are equal differ in their last digits.
            scaled = report is None or (again and report.joint == 0)
            found = self._after[report] = (JudgedMoment if scaled else moment)(belief), again
        return found


def moment(belief: Belief) -> JudgedMoment:
    """The moment at which this is known; one and the same for beliefs from which the same follows.

    Once there are :data:`MANY`, all are forgotten, since each holds those that follow from it.
    """
    if _moment.cache_info().currsize >= MANY:
        _moment.cache_clear()
    return _moment(belief)


@cache
def _moment(belief: Belief) -> JudgedMoment:
    return JudgedMoment(belief)
