"""Log-rank tests over p: whether noise changes the time to the first loop or to the solution.

A trial without the event is censored at its end. The variance allows for luck that trials share over all p
(:mod:`lockprobe.statistics.inference.excess`), except in :func:`independent_logrank`.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.broken_trials import opposed
from lockprobe.statistics.distributions import chi_squared_tail
from lockprobe.statistics.inference.excess import excess, grid
from lockprobe.statistics.loops.incidence import Incidence, incidence
from lockprobe.statistics.outcomes import Outcomes, joined

Steps = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True)
class EventGroup:
    """The time to the event in the trials of one or several p.

    Attributes:
        doses: The flip probabilities, ascending.
        n: Trials.
        events: Trials with the event.
        expected: Events expected by the end of each trial if p had no influence.
        curve: Share with the event by step, one minus Kaplan-Meier, which corrects for censoring.
    """

    doses: tuple[float, ...]
    n: int
    events: int
    expected: float
    curve: Incidence

    def by_step(self, step: int = 12) -> float:
        """Share with the event by this step, [0, 1]."""
        return self.curve.share[min(step, len(self.curve.share) - 1)]


@dataclass(frozen=True, slots=True, kw_only=True)
class EventComparison:
    """The lowest p compared with higher ones.

    Attributes:
        lowest: Trials at the lowest p.
        higher: Trials at the higher p.
        hazard_ratio: Observed over expected events, higher over lowest: below 1 if more noise means later and fewer
            events; None where undefined.
        direction: 1 if the event comes sooner or more often at the higher p, -1 if later or more rarely, else 0.
        p_value: Log-rank, two-sided; 1 if all trials are alike; None with six clusters of luck or fewer.
        p_adjusted: Corrected for the number of comparisons (Holm), if there are several.
    """

    lowest: EventGroup
    higher: EventGroup
    hazard_ratio: float | None
    direction: int
    p_value: float | None
    p_adjusted: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class LogRanks:
    """Log-rank tests of whether p changes the time to the event.

    Attributes:
        primary: The lowest p against all higher p pooled, which needs no choice of a peak; None with a single p.
        each: The lowest p against every higher p.
        p_all: P value of the k-sample log-rank test over all p; None with a single p, or too few clusters of luck ever
            to be significant (for seven p: twelve or fewer).
    """

    primary: EventComparison | None
    each: tuple[EventComparison, ...]
    p_all: float | None


def loop_onset_logrank(outcomes: Outcomes) -> LogRanks:
    """Log-rank tests of the step that completes the first loop; a trial without one is censored at its end.

    Censoring allows for trials that end earlier where success is more frequent. A permutation of p within clusters
    would not: it assumes equal censoring at all p.
    """
    return _over_p(outcomes, np.where(outcomes.looped, outcomes.onset, outcomes.length), outcomes.looped)


def solution_logrank(outcomes: Outcomes) -> LogRanks:
    """Log-rank tests of the step that solves the box; an unsolved trial is censored at its end."""
    return _over_p(outcomes, outcomes.length, outcomes.solved)


def bounded_speed(
    first: Outcomes, second: Outcomes, first_broken: Outcomes, second_broken: Outcomes, budget: int
) -> EventComparison | None:
    """Two groups of trials by the step that solves the box, second against first; None without a comparison.

    If trials broke, the P value is the larger of both ends (those of one group solved in the step in which they broke
    and those of the other never, and the reverse), and 1 if the directions differ.

    Args:
        first: The ended trials of the first group.
        second: Those of the second.
        first_broken: The trials of the first group that broke.
        second_broken: Those of the second.
        budget: Steps of a trial.
    """

    def compared(groups: Sequence[Outcomes]) -> EventComparison | None:
        return solution_logrank(joined(groups)).primary

    found, broken = compared((first, second)), (first_broken, second_broken)
    if found is None or not any(map(len, broken)):
        return found
    ends = opposed(compared, (first, second), broken, (False, True), budget)
    values = [one.p_value for one in ends if one and one.direction == found.direction and one.p_value is not None]
    missing = found.p_value is None or any(one is None or one.p_value is None for one in ends)
    return replace(found, p_value=None if missing else max(values) if len(values) == len(ends) else 1.0)


def independent_logrank(
    last: Steps,
    happened: NDArray[np.bool_],
    second: NDArray[np.bool_],
    *,
    weights: Literal["equal", "running"] = "equal",
) -> float | None:
    """Two-sided P value of the log-rank test of two groups of independent trials.

    The variance is hypergeometric. Shared luck with the same effect in both groups makes the test conservative.

    Args:
        last: The step of the event, or the last step without it, shape (trials,).
        happened: Whether the event happened at that step, of the same shape.
        second: Whether a trial belongs to the second group, of the same shape.
        weights: All steps alike, or each by the trials still running (Gehan-Wilcoxon), which has more power where
            groups differ early.

    Returns:
        None if at no step some but not all trials at risk had the event, with trials of both groups at risk.
    """
    running, event = grid(last, happened)
    n, events = running.sum(axis=0), event.sum(axis=0)
    share = running[second].sum(axis=0) / np.maximum(n, 1.0)
    weight = n if weights == "running" else np.ones_like(n)
    beyond = float(np.sum(weight * (event[second].sum(axis=0) - events * share)))
    spread = share * (1 - share) * events * (n - events) / np.maximum(n - 1, 1.0)
    variance = float(np.sum(weight**2 * spread))
    return chi_squared_tail(beyond**2 / variance, 1) if variance > 0 else None


def _over_p(outcomes: Outcomes, last: Steps, happened: NDArray[np.bool_]) -> LogRanks:
    levels = np.unique(outcomes.dose)
    if len(levels) < 2:
        return LogRanks(primary=None, each=(), p_all=None)
    luck = outcomes.cluster
    x = (outcomes.dose == levels[1:, None]).astype(np.float64)
    running, event = grid(last, happened)
    pairs = [(outcomes.dose == levels[0]) | (outcomes.dose == p) for p in levels[1:]]
    each = [_compare(outcomes.dose[pair], last[pair], happened[pair], luck[pair]) for pair in pairs]
    return LogRanks(
        primary=_compare(outcomes.dose, last, happened, luck),
        each=tuple(
            replace(comparison, p_adjusted=adjusted)
            for comparison, adjusted in zip(each, holm([one.p_value for one in each]), strict=True)
        ),
        p_all=excess(x, event, running, cluster=luck).p_value,
    )


def _compare(p: NDArray[np.float64], last: Steps, happened: NDArray[np.bool_], luck: Steps) -> EventComparison:
    """The lowest of these p against all others pooled."""
    higher = p > p.min()
    running, event = grid(last, happened)
    found = excess(higher[None].astype(np.float64), event, running, cluster=luck)
    beyond = float(found.total[0])
    first = _group(p[~higher], last[~higher], happened[~higher], -beyond)
    second = _group(p[higher], last[higher], happened[higher], beyond)
    defined = first.events and first.expected > 0 and second.expected > 0
    return EventComparison(
        lowest=first,
        higher=second,
        hazard_ratio=(second.events / second.expected) / (first.events / first.expected) if defined else None,
        direction=found.direction,
        p_value=found.p_value_t,
        p_adjusted=None,
    )


def _group(p: NDArray[np.float64], last: Steps, happened: NDArray[np.bool_], beyond: float) -> EventGroup:
    events = int(happened.sum())
    return EventGroup(
        doses=tuple(np.unique(p).tolist()),
        n=len(p),
        events=events,
        expected=events - beyond,
        curve=incidence(last, happened, int(last.max())),
    )


def holm(values: Sequence[float | None]) -> list[float | None]:
    """P values corrected for their number (Holm 1979); None where there is no test."""
    adjusted, largest = list(values), 0.0
    tested = sorted((value, i) for i, value in enumerate(values) if value is not None)
    for smaller, (value, i) in enumerate(tested):
        largest = max(largest, min(1.0, (len(tested) - smaller) * value))
        adjusted[i] = largest
    return adjusted


def holm_by_family(families: Sequence[Hashable], values: Sequence[float | None]) -> list[float | None]:
    """P values corrected for their number in each family, which has an entry of its own for each of them."""
    adjusted: list[float | None] = [None] * len(values)
    for family in dict.fromkeys(families):
        places = [i for i, other in enumerate(families) if other == family]
        for i, value in zip(places, holm([values[i] for i in places]), strict=True):
            adjusted[i] = value
    return adjusted
