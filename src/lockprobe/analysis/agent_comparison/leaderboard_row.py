"""One agent over all p: a row of the leaderboard, with trials clustered by luck and by person."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from lockprobe.analysis.agent_comparison.crossed_clusters import crossed_mean
from lockprobe.analysis.agent_comparison.paired import block_mean, by_cluster
from lockprobe.analysis.clustered import ClusteredProportion, clustered_proportion, crossed_proportion
from lockprobe.analysis.condition import ConditionSummary
from lockprobe.analysis.curves import success_curve
from lockprobe.analysis.misinterpretation import trial_claims
from lockprobe.analysis.outcomes import Outcomes, ended, outcomes
from lockprobe.analysis.reference import Reference
from lockprobe.record import Trial

__all__ = ["Regret", "Standing", "condition_regret", "standing"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Regret:
    """How much slower than the shortest plan, relative to a uniformly random agent on the same box.

    One less :class:`lockprobe.analysis.curves.Relative`: the area between the shortest plan's curve of success by step
    and the agent's, over that between the shortest plan's and the random agent's.

    Attributes:
        value: 0 as the shortest plan, 1 as a random agent; more if worse than random.
        low, high: Ends of the 95 % interval; None where it cannot be estimated.
    """

    value: float
    low: float | None
    high: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Standing:
    """One agent over all p.

    Attributes:
        agent: Agent spec.
        modality: How the box was shown.
        success: Trials solved; clusters are blocks of luck, and people.
        steps_to_80: The first step by which 80 % of all trials are solved; None if that never happens.
        regret: None where the box is not known or leaves no room between chance and the shortest plan.
        loops: Trials that hold an action loop.
        chance: Share that would hold one in trials of these lengths if actions were uniformly random, [0, 1];
            None without trials.
        chance_no_repeat: The same of random actions without immediate repeats.
        misread: Misinterpretations over claims.
        not_asked: Trials in which the agent was not asked for its claims.
        ranks: The best and the worst rank that the paired comparisons leave possible, from 1; None for an agent to
            compare with, and without trials.
    """

    agent: str
    modality: str
    success: ClusteredProportion
    steps_to_80: int | None
    regret: Regret | None
    loops: ClusteredProportion
    chance: float | None
    chance_no_repeat: float | None
    misread: ClusteredProportion
    not_asked: int
    ranks: tuple[int, int] | None = None


def standing(trials: Sequence[Trial], conditions: Sequence[ConditionSummary], reference: Reference | None) -> Standing:
    """One agent's row, from all its trials in one modality, the same by p, and the reference of the box."""
    counted, found = ended(trials), outcomes(trials)
    said = [trial_claims(trial) for trial in counted]
    curve = success_curve(trials)
    return Standing(
        agent=trials[0].group,
        modality=trials[0].modality,
        success=_share(found, found.solved, np.ones(len(found))),
        steps_to_80=curve.steps_to(0.8),
        regret=_regret(trials, reference),
        loops=_share(found, found.looped, np.ones(len(found))),
        chance=_pooled([(c.behaviour.chance_uniform, c.success.n) for c in conditions]),
        chance_no_repeat=_pooled([(c.behaviour.chance_no_repeat, c.success.n) for c in conditions]),
        misread=_share(found, [trial.misinterpreted for trial in said], [len(trial.claims) for trial in said]),
        not_asked=sum(not trial.assessment for trial in counted),
    )


def _share(found: Outcomes, counts: ArrayLike, sizes: ArrayLike) -> ClusteredProportion:
    """A share of trials clustered by luck, and for people also by person."""
    if found.crossed:
        return crossed_proportion(counts, sizes, found.player, found.luck)
    blocks = int(found.luck.max(initial=-1)) + 1
    summed = (np.bincount(found.luck, weights=np.asarray(of), minlength=blocks) for of in (counts, sizes))
    return clustered_proportion(*summed)


def condition_regret(condition: ConditionSummary) -> Regret | None:
    """The regret in one condition."""
    found = condition.relative
    return Regret(value=1 - found.value, low=1 - found.high, high=1 - found.low) if found else None


def _pooled(shares: Sequence[tuple[float | None, int]]) -> float | None:
    known = [(share, n) for share, n in shares if share is not None]
    return sum(share * n for share, n in known) / sum(n for _, n in known) if known else None


def _regret(trials: Sequence[Trial], reference: Reference | None) -> Regret | None:
    counted = outcomes(trials)
    budget = max((trial.budget for trial in trials), default=0)
    if reference is None or reference.optimum is None or not len(counted) or not budget:
        return None
    best = (budget - reference.optimum + 1) / budget
    room = best - sum(reference.random[1 : budget + 1]) / budget
    if room <= 0:
        return None
    area = np.where(counted.solved, (budget - counted.length + 1) / budget, 0.0)
    lost = (best - area) / room
    found = (
        crossed_mean(lost, counted.luck, counted.player)
        if counted.crossed
        else block_mean(by_cluster(lost, counted.luck))
    )
    return Regret(value=found.value, low=found.low, high=found.high)
