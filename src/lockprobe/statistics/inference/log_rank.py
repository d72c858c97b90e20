"""Log-rank tests: whether an event comes sooner or more often in some trials than in others.

A log-rank test sums, over steps, how far the events with a feature exceed those expected if all trials at risk were
alike. A trial without the event is censored at its end. Trials of equal repetition and trial share their luck over all
doses. So the differences are summed per cluster, and their variance between clusters is the robust variance of Lin and
Wei (1989), made unbiased for few running trials.

Rejections at .05 under the null hypothesis, in 1500 studies of 7 p x 30 trials with luck shared over p by none and by
half of the trials: loop onset .047 and .045 with Student's t, .056 and .056 with chi-squared.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.broken_trials import opposed, worst
from lockprobe.statistics.course import Course
from lockprobe.statistics.distributions import student_tails
from lockprobe.statistics.outcomes import Outcomes, joined, with_players_of
from lockprobe.statistics.proportions import ALPHA

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Hazard:
    """A log-rank test: whether an event comes sooner or more often with a feature.

    Attributes:
        total: Observed minus expected events with the feature.
        error: Its standard error between clusters of luck.
        p_value: Two-sided, of Student's t over clusters: 1 if all trials are alike, None with six clusters or fewer,
            where the statistic, which never exceeds their number, could never reject.
        value: Of two groups the hazard of the second over that of the first; None where undefined.
    """

    total: float = 0.0
    error: float = 0.0
    p_value: float | None = None
    value: float | None = None

    @property
    def direction(self) -> int:
        """1 if the event comes sooner or more often with the feature, -1 if later or more rarely, else 0."""
        return int(np.sign(self.total))


def grid(last: NDArray[np.int64], happened: NDArray[np.bool_]) -> tuple[Array, Array]:
    """At-risk and event indicators for each step from 1, both 0 or 1 of shape (trials, steps)."""
    step = np.arange(1, int(last.max(initial=0)) + 1)
    event = (last[:, None] == step) & happened[:, None]
    return (last[:, None] >= step).astype(np.float64), event.astype(np.float64)


def excess(feature: Array, last: NDArray[np.int64], happened: NDArray[np.bool_], cluster: NDArray[np.int64]) -> Hazard:
    """Excess of events with a feature, given the trials at risk at each step.

    Columns have the shape (trials,): the feature; the step of the event, or the last one without it; whether it
    happened there; the cluster of luck, from 0.
    """
    running, event = grid(last, happened)
    n = running.sum(axis=0)
    some = np.maximum(n, 1.0)
    score = running * (feature[:, None] - feature @ running / some) * (event - event.sum(axis=0) / some)
    unbiased = np.sum(score * np.sqrt(n / np.maximum(n - 1, 1.0)), axis=1)
    sums = np.round(np.bincount(cluster, weights=unbiased), 10)  # rounding noise is not evidence
    total, error, clusters = float(score.sum()), float(np.sqrt(sums @ sums)), len(sums)
    if clusters < 2 or student_tails(clusters**0.5, clusters - 1) >= ALPHA:
        return Hazard(total=total, error=error)
    p_value = float(student_tails(total / error, clusters - 1)) if error else 1.0
    return Hazard(total=total, error=error, p_value=p_value)


def log_rank(
    last: NDArray[np.int64], happened: NDArray[np.bool_], second: NDArray[np.bool_], cluster: NDArray[np.int64]
) -> Hazard:
    """Compare two groups, each with a trial; columns as in :func:`excess`, whose feature is to be in the second."""
    found = excess(second.astype(np.float64), last, happened, cluster)
    events = [int(happened[group].sum()) for group in (~second, second)]
    expected = [events[0] + found.total, events[1] - found.total]
    defined = events[0] and min(expected) > 0
    return replace(found, value=(events[1] / expected[1]) / (events[0] / expected[0]) if defined else None)


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

    ends = opposed(compared, groups, broken, (False, True), budget) if any(map(len, broken)) else ()
    return worst(compared(groups), ends)


def pace(first: Course, second: Course) -> Hazard | None:
    """How soon the second of two agents at one dose solves the box, against the first; None if one has no ended trial.

    Clusters are of the luck that they share, or of the people who met it.
    """
    one, two = first.outcomes, second.outcomes
    if not len(one) or not len(two):
        return None
    groups = with_players_of(two, one), with_players_of(one, two)
    broken = with_players_of(two, first.broken_off), with_players_of(one, second.broken_off)
    return solving(groups, broken, max(first.budget, second.budget))
