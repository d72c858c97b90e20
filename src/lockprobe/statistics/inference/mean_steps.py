"""Mean steps over doses: whether noise changes how many steps a trial takes.

An unsolved trial counts with its whole budget, so this is a restricted mean (Royston and Parmar, Statistics in Medicine
2011). A log-rank test loses its power where curves of success cross, as where false reports first slow an agent down
and then free it from a dead end. This test does not.

Rare long trials make the mean of few blocks skewed, so the variance has blocks of them that the sample may lack
(:mod:`lockprobe.statistics.rare_long_trials`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.clustered import two_way_variance
from lockprobe.statistics.outcomes import Outcomes
from lockprobe.statistics.rare_long_trials import rare_block


@dataclass(frozen=True, slots=True, kw_only=True)
class MeanSteps:
    """The mean steps at all higher doses together, less those at the lowest.

    Of agents the sample is every pair of trials with the same luck, one of them at the lowest dose; of people all
    trials.

    Attributes:
        value: The difference in steps; not a number without pairs.
        low, high: Ends of the 95 % interval; None where it cannot be estimated.
        p_value: That it is 0, Student's t over clusters, two-sided; None where it cannot be estimated.
        n: Size of the sample.
        note: Why there is no test, as a short code; empty if there is one.
    """

    value: float = math.nan
    low: float | None = None
    high: float | None = None
    p_value: float | None = None
    n: int = 0
    note: str = ""


def mean_steps(outcomes: Outcomes, budget: int) -> MeanSteps:
    """Compare the mean steps of all higher doses with those of the lowest.

    The standard error is clustered: of agents by luck, which trials share over doses; of people two-way, by person and
    by luck, with a correction for the number of people in each group. Student's t has one degree of freedom less than
    there are clusters (for people: in the group and of the kind with the fewest).
    """
    later = outcomes.dose > outcomes.dose.min(initial=math.inf)
    if not later.any():
        return MeanSteps(note="fewer than two doses")
    lowest, higher, variance, clusters, n = (_of_people if outcomes.crossed else _of_pairs)(outcomes, later)
    if not n:
        return MeanSteps(note="no common trial")
    change = higher - lowest
    if clusters < 2:
        return MeanSteps(value=change, n=n, note="too few clusters")
    error, rare = math.sqrt(variance), rare_block(lowest, higher, budget, float(outcomes.length.min()))
    low, high = rare.interval(change, error, clusters)
    return MeanSteps(
        value=change,
        low=max(-float(budget), low),
        high=min(float(budget), high),
        p_value=rare.p_value(change, error, clusters),
        n=n,
    )


_Compared = tuple[float, float, float, int, int]
"""Mean steps at the lowest dose and at the higher ones, variance of their difference, clusters, size of the sample."""


def _of_pairs(outcomes: Outcomes, later: NDArray[np.bool_]) -> _Compared:
    luck, steps = outcomes.luck, outcomes.length.astype(np.float64)
    blocks = int(luck.max()) + 1
    first, start = (np.bincount(luck[~later], weights, blocks) for weights in (None, steps[~later]))
    pairs, total = (np.bincount(luck[later], weights, blocks) for weights in (None, steps[later]))
    both = (first > 0) & (pairs > 0)
    sizes, before, after = pairs[both].astype(np.float64), (start * pairs)[both], total[both]
    n, every = len(sizes), int(sizes.sum())
    if not n:
        return math.nan, math.nan, math.nan, 0, 0
    lowest, higher = float(before.sum() / every), float(after.sum() / every)
    rest = after - before - (higher - lowest) * sizes
    return lowest, higher, n / max(n - 1, 1) * float(np.sum(rest**2)) / every**2, n, every


def _of_people(outcomes: Outcomes, later: NDArray[np.bool_]) -> _Compared:
    group, steps = later.astype(np.int64), outcomes.length.astype(np.float64)
    n, mean = np.bincount(group), np.bincount(group, weights=steps) / np.bincount(group)
    people, lucks = (
        np.array([len(np.unique(kind[side])) for side in (~later, later)], dtype=np.float64)
        for kind in (outcomes.player, outcomes.luck)
    )
    fewest, variance = int(min(*people, *lucks)), math.nan
    if fewest > 1:
        small = np.sqrt(people / (people - 1))  # each group's own correction: the lowest dose has far fewer people
        rest = (steps - mean[group]) * (2 * group - 1) * (small / n)[group]
        variance = two_way_variance(rest, outcomes.player, outcomes.luck)
    return float(mean[0]), float(mean[1]), variance, fewest, len(outcomes)
