"""Mean steps over p: whether noise changes how many steps a trial takes.

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

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class MeanSteps:
    """The mean number of steps at all higher p together, against the lowest p.

    Of agents the sample is every pair of trials with the same luck, one of them at the lowest p; of people all trials.

    Attributes:
        lowest: Mean steps at the lowest p; not a number without pairs.
        higher: Mean steps at the higher p.
        low, high: Ends of the 95 % interval of ``change``, in steps; None where it cannot be estimated.
        p_value: That the change is 0, Student's t over clusters, two-sided; None where it cannot be estimated.
        note: Why there is no test, as a short code; empty if there is one.
    """

    lowest: float
    higher: float
    low: float | None
    high: float | None
    p_value: float | None
    note: str = ""

    @property
    def change(self) -> float:
        """Mean steps at the higher p less those at the lowest."""
        return self.higher - self.lowest


def mean_steps(outcomes: Outcomes, budget: int) -> MeanSteps:
    """Compare the mean steps of all higher p with those of the lowest p.

    The standard error is clustered: of agents by luck, which trials share over p; of people two-way, by person and by
    luck, with a correction for the number of people in each group. Student's t has one degree of freedom less than
    there are clusters (for people: in the group and of the kind with the fewest).

    Args:
        outcomes: The ended trials of one agent.
        budget: Steps of a trial.
    """
    steps = outcomes.length.astype(np.float64)
    later = outcomes.dose > outcomes.dose.min(initial=math.inf)
    if not later.any():
        return _none("fewer than two doses")
    compared = _of_people(outcomes, steps, later) if outcomes.crossed else _of_pairs(outcomes, steps, later)
    return _none(compared) if isinstance(compared, str) else _tested(*compared, budget, float(steps.min()))


_Compared = tuple[float, float, float, int] | str
"""Mean steps at the lowest p and at the higher ones, variance of their difference, clusters; or why there are none."""


def _of_pairs(outcomes: Outcomes, steps: Array, later: NDArray[np.bool_]) -> _Compared:
    luck = outcomes.luck
    blocks = int(luck.max()) + 1
    first, start = (np.bincount(luck[~later], weights, blocks) for weights in (None, steps[~later]))
    pairs, total = (np.bincount(luck[later], weights, blocks) for weights in (None, steps[later]))
    both = (first > 0) & (pairs > 0)
    if not both.any():
        return "no common trial"
    sizes, before, after = pairs[both].astype(np.float64), (start * pairs)[both], total[both]
    n, lowest, higher = len(sizes), float(before.sum() / sizes.sum()), float(after.sum() / sizes.sum())
    rest = after - before - (higher - lowest) * sizes
    return lowest, higher, n / max(n - 1, 1) * float(np.sum(rest**2)) / float(sizes.sum()) ** 2, n


def _of_people(outcomes: Outcomes, steps: Array, later: NDArray[np.bool_]) -> _Compared:
    group = later.astype(np.int64)
    n, mean = np.bincount(group), np.bincount(group, weights=steps) / np.bincount(group)
    people, lucks = (_clusters_by_group(kind, later) for kind in (outcomes.player, outcomes.luck))
    fewest = int(min(*people, *lucks))
    if fewest < 2:
        return "too few clusters"
    small = np.sqrt(people / (people - 1))  # each group's own correction: the lowest p has far fewer people
    rest = (steps - mean[group]) * (2 * group - 1) * (small / n)[group]
    return float(mean[0]), float(mean[1]), two_way_variance(rest, outcomes.player, outcomes.luck), fewest


def _clusters_by_group(kind: NDArray[np.generic], later: NDArray[np.bool_]) -> Array:
    return np.array([len(np.unique(kind[~later])), len(np.unique(kind[later]))], dtype=np.float64)


def _tested(lowest: float, higher: float, variance: float, clusters: int, budget: int, shortest: float) -> MeanSteps:
    """Student's interval and test over clusters, with rare ones in the variance."""
    if clusters < 2:
        return MeanSteps(lowest=lowest, higher=higher, low=None, high=None, p_value=None, note="too few clusters")
    change, error, rare = higher - lowest, math.sqrt(variance), rare_block(lowest, higher, budget, shortest)
    low, high = rare.interval(change, error, clusters)
    return MeanSteps(
        lowest=lowest,
        higher=higher,
        low=max(-float(budget), low),
        high=min(float(budget), high),
        p_value=rare.p_value(change, error, clusters),
    )


def _none(note: str) -> MeanSteps:
    return MeanSteps(lowest=math.nan, higher=math.nan, low=None, high=None, p_value=None, note=note)
