"""Mantel-Haenszel tests of harm: whether success is rarer after an action loop than before any loop.

A solved trial is short, and a short trial holds fewer loops by chance alone (immortal time bias). So looping and
solving are compared *at one step, among the trials still running at it*, as the Mantel-Haenszel tests here do. The
variance allows for luck that trials share over all p (:mod:`lockprobe.statistics.inference.excess`).

The odds ratio of an agent that ignores all reports need not be 1: a repeated action may find the box unchanged. If
trials of a blind agent with the same action habits are given (:mod:`lockprobe.statistics.loops.habit_baseline`), their
odds ratio is the null hypothesis.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.inference.common_odds import common_odds
from lockprobe.statistics.inference.excess import Excess, grid, odds_excess, stratum_totals
from lockprobe.statistics.outcomes import Outcomes
from lockprobe.statistics.proportions import Z

__all__ = ["Blind", "LoopEffect", "loop_hazard"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Blind:
    """The simulated odds ratio of a blind agent with the same action habits on the same box.

    Attributes:
        odds_ratio: Over all strata, as for the agent; above 0.
        error: Monte Carlo standard error of its logarithm.
        trials: Number of simulated trials.
    """

    odds_ratio: float
    error: float
    trials: int


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopEffect:
    """The effect of a loop: the odds ratio of success after a loop against before any loop.

    Attributes:
        odds_ratio: Mantel-Haenszel's common odds ratio; below 1 if success is rarer after a loop; None if undefined.
        low, high: Ends of the 95 % interval; None if the ratio is 0 or undefined.
        blind: The null hypothesis: the odds ratio of a blind agent with the same habits; None if not known.
        direction: 1 if more are solved after a loop than under the null hypothesis, -1 if fewer, else 0.
        p_value: Two-sided, against ``blind``, or against 1 if no blind trials are given; None without an informative
            stratum.
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
    blind: Blind | None
    direction: int
    p_value: float | None
    strata: int
    looped: int
    looped_solved: int
    unlooped: int
    unlooped_solved: int
    note: str


def loop_hazard(outcomes: Outcomes, blind: Outcomes | None = None) -> LoopEffect:
    """Compare the hazard of success after a loop with that before any loop, in strata of p and step.

    A loop completed by the solving action does not count as a loop before it. Steps of one trial need no correction:
    each is compared given all trials at risk.

    Args:
        outcomes: The trials of one agent over all p.
        blind: Trials of a blind agent with the same habits on the same box; their odds ratio is the null hypothesis.
    """
    against = _blind_odds_ratio(loop_hazard(blind), len(blind)) if blind is not None else None
    running, event = grid(outcomes.length, outcomes.solved)
    step = np.arange(1, running.shape[1] + 1)
    looped = outcomes.looped[:, None] & (outcomes.onset[:, None] < step)
    return _with_null(_effect(outcomes, looped, event, running, against), blind)


def _blind_odds_ratio(found: LoopEffect, trials: int) -> Blind | None:
    """The odds ratio of simulated trials of a blind agent; None if it is not above 0."""
    if not found.odds_ratio or found.low is None or found.high is None:
        return None
    return Blind(odds_ratio=found.odds_ratio, error=math.log(found.high / found.low) / (2 * Z), trials=trials)


def _with_null(found: LoopEffect, blind: Outcomes | None) -> LoopEffect:
    """The effect against its null hypothesis; no test if blind trials are given and have no odds ratio."""
    if blind is None or found.blind is not None or found.p_value is None:
        return found
    return replace(found, p_value=None, direction=0, note="no odds ratio of a blind agent")


def _effect(
    outcomes: Outcomes, looped: NDArray[np.bool_], event: Array, running: Array, blind: Blind | None
) -> LoopEffect:
    """Mantel-Haenszel over strata of p and step; all grids have the shape (trials, steps)."""
    after, before = looped * running, ~looped * running
    cells = np.stack([after * event, after * (1 - event), before * event, before * (1 - event)])
    stratum = np.unique(outcomes.dose, return_inverse=True)[1]
    member = (outcomes.dose == np.unique(outcomes.dose)[:, None]).astype(np.float64)
    tables = stratum_totals(member, cells).reshape(2, 2, -1)
    informative = (tables.sum(axis=0).min(axis=0) > 0) & (tables.sum(axis=1).min(axis=0) > 0)
    found = odds_excess(cells, 1.0, stratum=stratum, cluster=outcomes.cluster)
    ratio, low, high = _with_interval(tables[..., informative], found)
    if blind:
        found = odds_excess(cells, blind.odds_ratio, stratum=stratum, cluster=outcomes.cluster)
        crossed = np.sum(tables[0, 1] * tables[1, 0] / np.maximum(tables.sum(axis=(0, 1)), 1))
        simulated = (blind.odds_ratio * crossed * blind.error) ** 2
        found = replace(found, covariance=found.covariance + simulated * (found.covariance > 0))
    (solved_after, failed_after), (solved_before, failed_before) = tables.sum(axis=2).astype(int).tolist()
    return LoopEffect(
        odds_ratio=ratio,
        low=low,
        high=high,
        blind=blind,
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
