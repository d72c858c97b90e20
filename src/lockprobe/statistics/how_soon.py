"""How soon: cumulative incidence by step (paper, Fig. 3), log-rank tests, and mean steps over doses.

The curve is one minus Kaplan-Meier: a trial that ends without the event is *censored*. With equal budgets the curve of
success is the plain share solved. A trial that broke in a step was not solved before it, and may have been solved in it
or never: the curve has bounds and is their middle. One minus Kaplan-Meier would be no estimate there, because long
trials break.

A log-rank test sums, over steps, how far the events with a feature exceed those expected if all trials at risk were
alike. Trials of equal repetition and trial share their luck over all doses and modalities. So the differences are
summed per cluster, and their variance between clusters is the robust variance of Lin and Wei (1989), made unbiased for
few running trials.

Rejections at .05 under the null hypothesis, in 1500 studies of 7 p x 30 trials with luck shared over p by none and by
half of the trials: loop onset .047 and .045 with Student's t, .056 and .056 with chi-squared. Those of the trend over
3 modalities in 4000 studies of ``human-inspired``: .017 and .002 with 10 trials each, .043 and .042 with 30
(``benchmarks/modality_rates.py``).

In mean steps an unsolved trial counts with its whole budget: a restricted mean (Royston and Parmar, Statistics in
Medicine 2011). A log-rank test loses its power where curves of success cross, as where false reports first slow an
agent down and then free it from a dead end. A test of means does not.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.grouping import grouped
from lockprobe.statistics.blocks import block_mean, blocks_of, rare_block
from lockprobe.statistics.broken_trials import bounded, whatever_broke, worst
from lockprobe.statistics.clustered import clustered_proportion
from lockprobe.statistics.differences import DifferenceAt, each_difference
from lockprobe.statistics.distributions import student_tails
from lockprobe.statistics.modalities import by_fidelity, fidelity
from lockprobe.statistics.multiple_testing import holm
from lockprobe.statistics.outcomes import Outcomes, joined
from lockprobe.statistics.proportions import ALPHA, Difference, wilson

if TYPE_CHECKING:
    from lockprobe.statistics.course import Course

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Incidence:
    """The share of trials with the event by step 0, 1, ... up to the horizon, and its band.

    The band is Wilson's interval for as many trials as carry the same Greenwood variance (Rothman 1978). Without early
    censoring it is exactly Wilson's interval of a plain share. Unlike the log-log band it exists at shares of 0 and 1.

    Attributes:
        n: Trials: all that were begun, or none if none ended.
        share: [0, 1]; the middle of the bounds where trials broke.
        low, high: Ends of the pointwise 95 % band, which holds whatever became of broken trials.
    """

    n: int
    share: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]

    def steps_to(self, share: float) -> tuple[int | None, ...]:
        """The first step by which at least this share of the trials is solved, and the ends of its 95 % interval.

        The ends are from those of the band. None means beyond the budget.
        """
        lines = (self.share, self.high, self.low)
        return tuple(next((step for step, at in enumerate(line) if at >= share - 1e-12), None) for line in lines)

    @property
    def restricted_mean_steps(self) -> float | None:
        """Mean steps over *all* trials, unsolved ones counted with the whole budget; None without trials."""
        return sum(1 - share for share in self.share[:-1]) if self.n else None


def success_curve(outcomes: Outcomes) -> Incidence:
    """Cumulative success over the trials of one condition, with a band clustered by player."""
    counted, begun, ends = len(outcomes.ended), len(outcomes), list[Incidence]()
    for of in [outcomes.completed(soon) for soon in (False, True)] if 0 < counted < begun else [outcomes.ended]:
        effect = 1.0
        if of.crossed:  # else all trials are independent
            effect = clustered_proportion(of.solved, np.ones(len(of)), of.player, of.luck).design_effect
        ends.append(incidence(of.length, of.solved, outcomes.budget, effect))
    share = np.array([one.share for one in ends]).mean(axis=0)
    return Incidence(n=counted and begun, share=tuple(share.tolist()), low=ends[0].low, high=ends[-1].high)


def incidence(
    steps: NDArray[np.integer[Any]], happened: NDArray[np.bool_], horizon: int, design_effect: float = 1.0
) -> Incidence:
    """One minus Kaplan-Meier up to the horizon, computed in whole numbers, so that plain shares are exact.

    Columns have the shape (trials,): the step of the event, or the last one without it, and whether it happened there.
    The design effect is the variance relative to that of independent trials, >= 1.
    """
    left = np.bincount(steps, minlength=horizon + 1)[: horizon + 1]
    running = (len(steps) - np.cumsum(left) + left).tolist()
    events = np.bincount(steps[happened], minlength=horizon + 1)[: horizon + 1].tolist()
    share, low, high = [], [], []
    remaining, whole, hazard, size = 1, 1, 0.0, 0.0
    for n, d in zip(running, events, strict=True):
        before = remaining / whole
        if d:
            remaining, whole = remaining * (n - d), whole * n
            hazard += d / (n * (n - d)) if d < n else 0.0
        reached = (whole - remaining) / whole
        if 0 < remaining < whole:
            size = reached / (remaining / whole * hazard)
        elif n:
            size = n / before  # Peto's: as many trials as would leave n running
        down, up = wilson(reached, size, design_effect=design_effect)
        share.append(reached if len(steps) else math.nan)
        low.append(down)
        high.append(up if n or not remaining else 1.0)
    return Incidence(n=len(steps), share=tuple(share), low=tuple(low), high=tuple(high))


@dataclass(frozen=True, slots=True, kw_only=True)
class Hazard:
    """A log-rank test: whether an event comes sooner or more often with a feature.

    Attributes:
        total: Observed minus expected events with the feature.
        error: Its standard error between clusters of luck.
        p_value: Two-sided, of Student's t over clusters: 1 if all trials are alike, None with six clusters or fewer,
            where the statistic, which never exceeds the square root of their number, could never reject.
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

    Columns have the shape (trials,): the feature, or its value at each step, (trials, steps); the step of the event, or
    the last one without it; whether it happened there; the cluster of luck, from 0.
    """
    running, event = grid(last, happened)
    n, by_step = running.sum(axis=0), feature.reshape(len(feature), -1)
    some = np.maximum(n, 1.0)
    score = running * (by_step - (by_step * running).sum(axis=0) / some) * (event - event.sum(axis=0) / some)
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


def looping(counted: Outcomes) -> Hazard | None:
    """How soon an agent loops at all doses above the lowest, against the lowest; None with a single dose.

    Censoring allows for trials that end earlier where success is more frequent. A permutation of doses within clusters
    would not: it assumes equal censoring at all of them.
    """
    higher = counted.dose > counted.dose.min(initial=np.inf)
    return log_rank(counted.until_loop, counted.looped, higher, counted.cluster) if higher.any() else None


def solving(first: Outcomes, second: Outcomes) -> Hazard:
    """How soon the box is solved in the second of two groups of trials, whatever became of those that broke."""

    def compared(of: Sequence[Outcomes]) -> Hazard:
        both = joined(of)
        return log_rank(both.length, both.solved, both.dose > 0, both.cluster)

    return whatever_broke(compared, (first, second), (False, True), worst)


class ModalityEffect(NamedTuple):
    """The effect of the modality on one agent at its lowest flip rate (paper, Sec. 3.1, Fig. 3, Table 1).

    Attributes:
        modalities: From low to high fidelity.
        trend: Log-rank test of a trend over fidelity in equal steps (Tarone 1975), corrected for agents. Variants of a
            modality (``rgbd?blur=8``) have equal fidelity. Without P value with one fidelity or too few clusters.
        pairs: Every two modalities, the second of higher fidelity: how soon the box is solved in it, corrected for the
            pairs (Holm) and for agents, and its final success and mean steps less those in the first, corrected for
            both (Bonferroni); None without a trial of equal luck in both.
        agents: Number of agents that are judged together.
    """

    agent: str
    modalities: tuple[str, ...]
    trend: Hazard
    pairs: tuple[tuple[str, str, Hazard, DifferenceAt | None, Difference], ...]
    agents: int


def modality_effects(agents: Sequence[Course]) -> Iterator[ModalityEffect]:
    """The effect on every agent with ended trials in several modalities, at the lowest flip rate of all.

    The agents that the study is about are judged together, and so are baselines.
    """
    least = min((one.doses[0] for one in agents), default=0.0)
    lowest = (one.lowest for one in agents if one.doses[0] == least)
    shown = grouped((one for one in lowest if len(one.outcomes.ended)), lambda one: one.agent)
    several = [sorted(own, key=lambda one: by_fidelity(one.modality)) for own in shown.values() if len(own) > 1]
    kinds = [own[0].baseline for own in several]
    for own, kind in zip(several, kinds, strict=True):
        together = kinds.count(kind)
        pairs, trend = [*combinations(own, 2)], _trend(own)
        hazards = [solving(one.outcomes, two.outcomes) for one, two in pairs]
        tested = zip((trend, *hazards), (trend.p_value, *holm([one.p_value for one in hazards])), strict=True)
        trend, *hazards = (replace(of, p_value=None if p is None else min(1.0, together * p)) for of, p in tested)
        choices = together * len(pairs)
        compared = []
        for (one, two), soon in zip(pairs, hazards, strict=True):
            both = one.outcomes, two.outcomes
            final = next((found for _, found in each_difference(both, agents=choices)), None)
            steps = steps_over_doses(joined(both, (0, 1)), choices=choices)
            compared.append((one.modality, two.modality, soon, final, steps))
        yield ModalityEffect(own[0].agent, tuple(one.modality for one in own), trend, tuple(compared), together)


def _trend(shown: Sequence[Course]) -> Hazard:
    """The trend over fidelity; those that broke at the lowest fidelity against all others."""
    ranked = [(float(rank), one.outcomes) for one in shown if (rank := fidelity(one.modality)) is not None]
    ranks = [rank for rank, _ in ranked]
    if len(set(ranks)) < 2:
        return Hazard()

    def trend(groups: Sequence[Outcomes]) -> Hazard:
        every = joined(groups)
        return excess(np.repeat(ranks, [*map(len, groups)]), every.length, every.solved, every.cluster)

    return whatever_broke(trend, [of for _, of in ranked], [rank > min(ranks) for rank in ranks], worst)


def steps_over_doses(outcomes: Outcomes, *, choices: int = 1) -> Difference:
    """The mean steps at all higher doses together, less those at the lowest; not a number without pairs.

    Interval and P value allow for several choices.

    The sample is every pair of trials with the same luck, one of them at the lowest dose, clustered by luck. People,
    who meet no luck twice, have none.
    """
    begun = outcomes.at_ended_doses
    later, budget = begun.dose > begun.dose.min(initial=math.inf), float(begun.budget)

    def mean(of: Sequence[Outcomes]) -> Difference:
        doses = np.unique(of[0].dose)
        if len(doses) > 1 and not of[0].crossed:
            steps = blocks_of([of[0].at(of[0].dose == dose) for dose in doses]).steps
            lowest, higher = np.broadcast_to(steps[:, :1], steps[:, 1:].shape), steps[:, 1:]
            both = ~np.isnan(higher - lowest)
            if both.any():
                return block_mean(
                    higher - lowest, unit=budget, choices=choices, rare=rare_block(lowest[both], higher[both], budget)
                )
        return Difference(value=math.nan)

    def held(found: Difference, low: Difference, high: Difference) -> Difference:
        return found if found.p_value is None else bounded(found, low, high)

    return whatever_broke(mean, [begun], [later], held)
