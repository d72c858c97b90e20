"""One row of the leaderboard: an agent's results over all p, clustered by luck and by person."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from lockprobe.statistics.agent_comparison.crossed_clusters import crossed_mean
from lockprobe.statistics.agent_comparison.paired import block_mean, by_cluster
from lockprobe.statistics.clustered import ClusteredProportion, clustered_proportion, crossed_proportion
from lockprobe.statistics.conditions.axis_trials import AxisTrials
from lockprobe.statistics.conditions.condition import ConditionSummary
from lockprobe.statistics.curves import success_curve
from lockprobe.statistics.misinterpretation import trial_claims
from lockprobe.statistics.outcomes import Outcomes, ended, outcomes
from lockprobe.statistics.reference import Reference

__all__ = ["Regret", "Standing", "standing"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Regret:
    """Regret: how much slower than the shortest plan, on a scale where a uniformly random agent has 1.

    It equals 1 minus :class:`lockprobe.statistics.curves.Relative`: the area between the success curves of the shortest
    plan and the agent, divided by the area between those of the shortest plan and the random agent.

    Attributes:
        value: 0 for the shortest plan, 1 for a random agent, above 1 if worse than random.
        low, high: Ends of the 95 % interval; None where it cannot be estimated.
    """

    value: float
    low: float | None
    high: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Standing:
    """One agent over all p.

    Attributes:
        agent: Its name, or its spec if it has none.
        modality: How the box was shown.
        success: Share of trials solved, clustered by luck and by person.
        steps_to_80: The first step by which 80 % of all trials are solved; None if that never happens.
        regret: None where the box is not known or leaves no room between chance and the shortest plan.
        loops: Share of trials that hold an action loop.
        chance: The chance level of ``loops``: the share expected of uniformly random actions in trials of these
            lengths, [0, 1]; None without trials.
        chance_no_repeat: The same of random actions without immediate repeats.
        misread: Misinterpretation rate: misinterpretations per claim.
        not_asked: Trials in which the agent was not asked for claims.
        ranks: Best and worst possible rank given the paired comparisons, from 1; None for baselines and without
            trials.
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


def standing(of: AxisTrials, conditions: Sequence[ConditionSummary], reference: Reference | None) -> Standing:
    """One agent's row, from its trials in one modality, its conditions by p, and the box's reference curves."""
    trials = of.trials
    counted, found = ended(trials), outcomes(trials)
    said = [trial_claims(trial) for trial in counted]
    curve = success_curve(trials)
    return Standing(
        agent=of.agent,
        modality=of.modality,
        success=_share(found, found.solved, np.ones(len(found))),
        steps_to_80=curve.steps_to(0.8),
        regret=_regret(found, max((trial.budget for trial in trials), default=0), reference),
        loops=_share(found, found.looped, np.ones(len(found))),
        chance=_pooled([(c.behaviour.chance_uniform, c.success.n) for c in conditions]),
        chance_no_repeat=_pooled([(c.behaviour.chance_no_repeat, c.success.n) for c in conditions]),
        misread=_share(found, [trial.misinterpreted for trial in said], [len(trial.claims) for trial in said]),
        not_asked=sum(not trial.assessment for trial in counted),
    )


def _share(found: Outcomes, counts: ArrayLike, sizes: ArrayLike) -> ClusteredProportion:
    """A share of trials, clustered by luck and for people also by person."""
    if found.crossed:
        return crossed_proportion(counts, sizes, found.player, found.luck)
    blocks = int(found.luck.max(initial=-1)) + 1
    summed = (np.bincount(found.luck, weights=np.asarray(of), minlength=blocks) for of in (counts, sizes))
    return clustered_proportion(*summed)


def _pooled(shares: Sequence[tuple[float | None, int]]) -> float | None:
    known = [(share, n) for share, n in shares if share is not None]
    return sum(share * n for share, n in known) / sum(n for _, n in known) if known else None


def _regret(counted: Outcomes, budget: int, reference: Reference | None) -> Regret | None:
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
