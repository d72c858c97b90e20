"""Mantel-Haenszel tests of harm: whether success is rarer after an action loop than before any loop.

A solved trial is short, and a short trial holds fewer loops by chance alone (immortal time bias). So looping and
solving are compared *at one step, among the trials still running at it*, as the Mantel-Haenszel tests here do. The
variance allows for luck that trials share over all p (:mod:`lockprobe.statistics.inference.excess`).

The null hypothesis is an odds ratio of 1. That of an agent that ignores all reports need not be 1: a repeated action
may find the box unchanged.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.inference.common_odds import common_odds
from lockprobe.statistics.inference.excess import Excess, excess, grid
from lockprobe.statistics.outcomes import Outcomes
from lockprobe.statistics.proportions import Z

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopEffect:
    """The effect of a loop: the odds ratio of success after a loop against before any loop.

    Attributes:
        odds_ratio: Mantel-Haenszel's common odds ratio; below 1 if success is rarer after a loop; None if undefined.
        low, high: Ends of the 95 % interval; None if the ratio is 0 or undefined.
        direction: 1 if more are solved after a loop than before any, -1 if fewer, else 0.
        p_value: Two-sided, against 1; None without an informative stratum.
        strata: Number of informative strata: trials with and without a loop, some but not all solved.
        looped: Steps after a loop.
        looped_solved: How many of them solved the box.
        unlooped: Steps before any loop.
        unlooped_solved: How many of them solved the box.
        note: Why there is no test, as a short code; empty if there is one.
    """

    odds_ratio: float | None
    low: float | None
    high: float | None
    direction: int
    p_value: float | None
    strata: int
    looped: int
    looped_solved: int
    unlooped: int
    unlooped_solved: int
    note: str


def loop_hazard(outcomes: Outcomes) -> LoopEffect:
    """Compare the hazard of success after a loop with that before any loop, in strata of p and step.

    A loop completed by the solving action does not count as a loop before it. Steps of one trial need no correction:
    each is compared given all trials at risk.
    """
    running, event = grid(outcomes.length, outcomes.solved)
    step = np.arange(1, running.shape[1] + 1)
    looped = outcomes.looped[:, None] & (outcomes.onset[:, None] < step)
    after, before = looped * running, ~looped * running
    cells = np.stack([after * event, after * (1 - event), before * event, before * (1 - event)])
    stratum = np.unique(outcomes.dose, return_inverse=True)[1]
    member = (outcomes.dose == np.unique(outcomes.dose)[:, None]).astype(np.float64)
    tables = np.stack([member @ one for one in cells]).reshape(2, 2, -1)
    informative = (tables.sum(axis=0).min(axis=0) > 0) & (tables.sum(axis=1).min(axis=0) > 0)
    found = excess(looped[None].astype(np.float64), event, running, stratum=stratum, cluster=outcomes.cluster)
    ratio, low, high = _with_interval(tables[..., informative], found)
    (solved_after, failed_after), (solved_before, failed_before) = tables.sum(axis=2).astype(int).tolist()
    return LoopEffect(
        odds_ratio=ratio,
        low=low,
        high=high,
        direction=found.direction,
        p_value=found.p_value if informative.any() else None,
        strata=int(informative.sum()),
        looped=solved_after + failed_after,
        looped_solved=solved_after,
        unlooped=solved_before + failed_before,
        unlooped_solved=solved_before,
        note="" if informative.any() else "never side by side",
    )


def _with_interval(tables: Array, found: Excess) -> tuple[float | None, float | None, float | None]:
    """The common odds ratio of tables of shape (2, 2, strata), and its interval.

    The interval is Robins, Breslow and Greenland's, widened by the ratio of the variance between clusters to that of
    independent trials.
    """
    common = common_odds(tables)
    if common is None:
        return None, None, None
    if common.log_error is None or found.clusters < 2:
        return common.ratio, None, None
    n = tables.sum(axis=(0, 1))
    margins = tables.sum(axis=1).prod(axis=0) * tables.sum(axis=0).prod(axis=0)
    independent = float(np.sum(margins / (n**2 * (n - 1))))
    spread = Z * common.log_error * math.sqrt(float(found.covariance[0, 0]) / independent)
    return common.ratio, common.ratio * math.exp(-spread), common.ratio * math.exp(spread)
