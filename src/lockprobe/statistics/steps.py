"""Mean steps over doses: whether they change them, with rare long trials in the variance.

An unsolved trial counts with its whole budget, so this is a restricted mean (Royston and Parmar, Statistics in Medicine
2011). A log-rank test loses its power where curves of success cross, as where false reports first slow an agent down
and then free it from a dead end. A test of means does not.
"""

from __future__ import annotations

import math

import numpy as np

from lockprobe.statistics.blocks import block_mean, blocks_of, rare_block
from lockprobe.statistics.broken_trials import bounded, whatever_broke
from lockprobe.statistics.clustered import clustered_variance, student
from lockprobe.statistics.outcomes import Outcomes
from lockprobe.statistics.proportions import Difference


def steps_over_doses(outcomes: Outcomes) -> Difference:
    """The mean steps at all higher doses together, less those at the lowest; not a number without pairs.

    Of agents the sample is every pair of trials with the same luck, one of them at the lowest dose, clustered by luck;
    of people all trials, clustered by person and by luck, with a correction for the number of people in each group.
    Student's t has one degree of freedom less than there are clusters (for people: in the group and of the kind with
    the fewest).
    """
    begun = outcomes.at_ended_doses
    later = begun.dose > begun.dose.min(initial=math.inf)

    def held(found: Difference, low: Difference, high: Difference) -> Difference:
        return found if found.p_value is None else bounded(found, low, high)

    return whatever_broke(lambda of: _over_doses(of[0]), [begun], [later], held)


def _over_doses(outcomes: Outcomes) -> Difference:
    doses, budget = np.unique(outcomes.dose), float(outcomes.budget)
    if len(doses) < 2:
        return Difference(value=math.nan)
    if outcomes.crossed:
        return _of_people(outcomes, budget)
    steps = blocks_of([outcomes.at(outcomes.dose == dose) for dose in doses]).steps
    lowest, higher = np.broadcast_to(steps[:, :1], steps[:, 1:].shape), steps[:, 1:]
    both = ~np.isnan(higher - lowest)
    if not both.any():
        return Difference(value=math.nan)
    return block_mean(higher - lowest, unit=budget, rare=rare_block(lowest[both], higher[both], budget))


def _of_people(outcomes: Outcomes, budget: float) -> Difference:
    later, steps = outcomes.dose > outcomes.dose.min(), outcomes.length.astype(np.float64)
    group = later.astype(np.int64)
    n, mean = np.bincount(group), np.bincount(group, weights=steps) / np.bincount(group)
    people, lucks = (
        np.array([len(np.unique(kind[side])) for side in (~later, later)], dtype=np.float64)
        for kind in (outcomes.player, outcomes.luck)
    )
    fewest, found = int(min(*people, *lucks)), Difference(value=float(mean[1] - mean[0]), n=len(outcomes))
    if fewest < 2:
        return found
    small = np.sqrt(people / (people - 1))  # each group's own correction: the lowest dose has far fewer people
    rest = (steps - mean[group]) * (2 * group - 1) * (small / n)[group]
    variance, rare = (
        clustered_variance(rest, outcomes.player, outcomes.luck),
        rare_block(steps[~later], steps[later], budget),
    )
    return student(found, variance, fewest, more=rare.more(1 / fewest), most=budget)
