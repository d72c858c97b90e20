"""Log-rank tests of two groups of trials: whether an event comes sooner or more often in the second.

A trial without the event is censored at its end. The variance allows for luck that trials share
(:mod:`lockprobe.statistics.inference.excess`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.broken_trials import opposed
from lockprobe.statistics.inference.excess import excess
from lockprobe.statistics.outcomes import Outcomes, joined


@dataclass(frozen=True, slots=True, kw_only=True)
class Hazard:
    """How soon an event comes.

    Attributes:
        ratio: Hazard of the second group over that of the first; None where undefined.
        direction: 1 if the event comes sooner or more often in the second, -1 if later or more rarely, else 0.
        p_value: Two-sided; 1 if all trials are alike; None with six clusters of luck or fewer.
    """

    ratio: float | None
    direction: int
    p_value: float | None


def log_rank(
    last: NDArray[np.int64], happened: NDArray[np.bool_], second: NDArray[np.bool_], cluster: NDArray[np.int64]
) -> Hazard:
    """Compare two groups, each with a trial. Every column has the shape (trials,).

    Args:
        last: The step of the event, or the last step without it.
        happened: Whether the event happened at that step.
        second: Whether the trial belongs to the second group.
        cluster: Its cluster of luck, from 0.
    """
    found = excess(second.astype(np.float64), last, happened, cluster)
    events = [int(happened[group].sum()) for group in (~second, second)]
    expected = [events[0] + found.total, events[1] - found.total]
    defined = events[0] and min(expected) > 0
    ratio = (events[1] / expected[1]) / (events[0] / expected[0]) if defined else None
    return Hazard(ratio=ratio, direction=found.direction, p_value=found.p_value)


def looping(outcomes: Outcomes) -> Hazard | None:
    """How soon an agent loops at all doses above the lowest, against the lowest; None with a single dose.

    Censoring allows for trials that end earlier where success is more frequent. A permutation of doses within clusters
    would not: it assumes equal censoring at all of them.
    """
    higher = outcomes.dose > outcomes.dose.min(initial=np.inf)
    return log_rank(outcomes.until_loop, outcomes.looped, higher, outcomes.cluster) if higher.any() else None


def solving(groups: Sequence[Outcomes], broken: Sequence[Outcomes], budget: int) -> Hazard:
    """How soon the box is solved in the second of two groups of ended trials, whatever became of those that broke."""

    def compared(of: Sequence[Outcomes]) -> Hazard:
        both = joined(of)
        return log_rank(both.length, both.solved, both.dose > 0, both.cluster)

    found = compared(groups)
    if not any(map(len, broken)):
        return found
    return worst(found, opposed(compared, groups, broken, (False, True), budget))


def worst(found: Hazard, ends: Sequence[Hazard]) -> Hazard:
    """A comparison without broken trials with the larger P value of both ends, and 1 if the directions differ."""
    values = [one.p_value for one in (found, *ends) if one.p_value is not None]
    if len(values) <= len(ends):
        return replace(found, p_value=None)
    alike = len({one.direction for one in (found, *ends)}) == 1
    return replace(found, p_value=max(values[1:]) if alike else 1.0)
