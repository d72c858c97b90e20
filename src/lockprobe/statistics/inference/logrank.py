"""Log-rank tests over p: whether noise changes the time to the first loop.

A trial without the event is censored at its end. The variance allows for luck that trials share over all p
(:mod:`lockprobe.statistics.inference.excess`).
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.inference.excess import excess, grid
from lockprobe.statistics.loops.incidence import Incidence, incidence
from lockprobe.statistics.outcomes import Outcomes

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
