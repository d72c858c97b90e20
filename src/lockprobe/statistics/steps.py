"""Mean steps: differences with rare long trials in their variance, and whether doses change them.

An unsolved trial counts with its whole budget, so this is a restricted mean (Royston and Parmar, Statistics in Medicine
2011). A log-rank test loses its power where curves of success cross, as where false reports first slow an agent down
and then free it from a dead end. A test of means does not.

An agent that is mostly a little faster and now and then needs its whole budget is no faster, and a sample without such
a trial has neither its mean nor its spread. So three more blocks are added to the variance, as Agresti and Min (2005)
add pairs that differ to shares. In each, one of the two takes the whole budget, or as few steps as the shortest trial,
and the other what it takes on average, whichever is farther.

Three are enough for every budget. Rare blocks have a Poisson distribution. A decrease is said after k of them if more
than k + 1.96 sqrt(k + 3) were to be expected, and at most 5 % of samples have so few.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.broken_trials import bounded, whatever_broke
from lockprobe.statistics.clustered import student, two_way_variance
from lockprobe.statistics.outcomes import Outcomes
from lockprobe.statistics.proportions import Difference

BLOCKS = 3
"""Blocks that are added to the variance."""


class RareBlock(NamedTuple):
    """How far below and above a mean difference in steps a rare block may lie."""

    below: float
    above: float

    def more(self, share: float) -> tuple[float, float]:
        """What rare blocks add to the variance of a mean below and above it.

        ``share`` is the size of a rare block as a share of the sample.
        """
        return BLOCKS * (share * self.below) ** 2, BLOCKS * (share * self.above) ** 2


def rare_block(first: float, second: float, budget: float, shortest: float) -> RareBlock:
    """How far a rare block may lie from the difference in steps of two agents, or of one under two conditions.

    ``first`` and ``second`` are their mean steps, of which the first are taken from the second; ``shortest`` are the
    steps of the shortest trial of both. A rare one is taken to be as short, or a fifth of the budget.
    """
    least = min(shortest, budget / 5)
    return RareBlock(max(budget - second, first - least, 1.0), max(budget - first, second - least, 1.0))


def steps_over_doses(outcomes: Outcomes) -> Difference:
    """The mean steps at all higher doses together, less those at the lowest; not a number without pairs.

    Of agents the sample is every pair of trials with the same luck, one of them at the lowest dose; of people all
    trials.

    The standard error is clustered: of agents by luck, which trials share over doses; of people two-way, by person and
    by luck, with a correction for the number of people in each group. Student's t has one degree of freedom less than
    there are clusters (for people: in the group and of the kind with the fewest).
    """
    begun = outcomes.at_ended_doses
    later = begun.dose > begun.dose.min(initial=math.inf)

    def held(found: Difference, low: Difference, high: Difference) -> Difference:
        return found if found.p_value is None else bounded(found, low, high)

    return whatever_broke(lambda of: _over_doses(of[0]), [begun], [later], held)


def _over_doses(outcomes: Outcomes) -> Difference:
    later = outcomes.dose > outcomes.dose.min(initial=math.inf)
    if not later.any():
        return Difference(value=math.nan)
    lowest, higher, variance, clusters, n = (_of_people if outcomes.crossed else _of_pairs)(outcomes, later)
    budget, found = float(outcomes.budget), Difference(value=higher - lowest, n=n)
    if clusters < 2:
        return found
    rare = rare_block(lowest, higher, budget, float(outcomes.length.min()))
    return student(found, variance, clusters, more=rare.more(1 / clusters), most=budget)


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
