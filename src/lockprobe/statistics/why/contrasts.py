"""The analysis of the study ``why``: success in every arm of one agent, and what reports do as false reports do.

:mod:`lockprobe.statistics.why.arms` has the arms, :mod:`lockprobe.statistics.why.mechanism` the rule.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.agent_comparison.paired import Array, BlockMean, sheets
from lockprobe.statistics.broken_trials import completed
from lockprobe.statistics.clustered import share_of
from lockprobe.statistics.conditions.series import SeriesArm
from lockprobe.statistics.distributions import normal_quantile
from lockprobe.statistics.inference.holm import holm
from lockprobe.statistics.outcomes import Outcomes, broken_off, outcomes
from lockprobe.statistics.proportions import ALPHA, Proportion
from lockprobe.statistics.sequential.order import BlockOrder
from lockprobe.statistics.sequential.shares import share_at_every_look
from lockprobe.statistics.why.arms import PLANNED, arms_of
from lockprobe.statistics.why.mechanism import MARGIN, Decision, bounded_contrast, decide
from lockprobe.trial.record import Trial

_POWER = 0.8
"""The power for which the needed blocks are computed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmEffect:
    """Success in one arm, and its change from the arm with true reports.

    Attributes:
        arm: As in :mod:`lockprobe.statistics.why.arms`.
        condition: The name of the condition in the study.
        success: Share solved.
        change: Success minus success under true reports, over blocks, [-1, 1]; None for the arm of true reports, and
            for all arms unless the total effect is detected. Its P value is corrected for the number of
            arms (Holm); its interval is not. Both are for that of agents.
    """

    arm: str
    condition: str
    success: Proportion
    change: BlockMean | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Why:
    """Why false reports change the success of one agent.

    All intervals and P values are corrected for the agents that are judged together (Bonferroni), so that a verdict on
    some of them is wrong in at most 5 % of studies.

    Attributes:
        agent: Its name, or its spec if it has none.
        modality: How the box was shown.
        p: The rate at which reports were hit, (0, 1].
        arms: Success in each arm.
        decision: The total effect, the contrasts of arms, the claims and the verdict.
        margin: The equivalence margin, (0, 1).
        needed: Blocks needed to detect a change of the margin with a power of 80 %, given the variance of these blocks.
        agents: Number of agents (and ways of showing the box) that are judged together.
        every_look: Whether intervals and P values hold at every look.
    """

    agent: str
    modality: str
    p: float
    arms: tuple[ArmEffect, ...]
    decision: Decision
    margin: float = MARGIN
    needed: int
    agents: int = 1
    every_look: bool = False

    @property
    def detected(self) -> bool:
        """Whether false reports change success; nothing else is tested where they do not."""
        return bool(self.decision.contrasts)

    def success(self, arm: str) -> Proportion:
        """Success in an arm that was played."""
        return next(one.success for one in self.arms if one.arm == arm)


def why(
    trials: Mapping[str, Sequence[Trial]],
    conditions: Sequence[SeriesArm],
    *,
    margin: float = MARGIN,
    agents: int = 1,
    order: BlockOrder | None = None,
) -> Why | None:
    """Analyse why lies change the success of one agent in one modality.

    Args:
        trials: Condition -> the agent's trials.
        conditions: The conditions with their specs.
        margin: Equivalence margin: smaller changes count as none, (0, 1).
        agents: Number of agents (and ways of showing the box) that are judged together.
        order: The order of the blocks, if everything must hold at every look.

    Returns:
        None unless two blocks or more have a trial in each planned arm.
    """
    if (found := arms_of(conditions)) is None:
        return None
    p, names = found
    played = {
        arm: (ended, broken_off(members, order=order))
        for arm, name in names.items()
        for members in [trials.get(name, ())]
        if len(ended := outcomes(members, order=order))
    }
    if not played.keys() >= set(PLANNED):
        return None
    solved, broke = _by_block(played)
    if int((~np.isnan(np.sum([solved[arm] for arm in PLANNED], axis=0))).sum()) < 2:
        return None
    first = trials[names["truth"]][0]
    every = order is not None
    decision = decide(solved, broke=broke, margin=margin, agents=agents, every_look=every)
    return Why(
        agent=first.group,
        modality=first.modality,
        p=p,
        arms=_arms(names, solved, broke, agents, all_arms=bool(decision.contrasts), every_look=every),
        decision=decision,
        margin=margin,
        needed=_needed(solved["lie"] - solved["truth"], margin, agents),
        agents=agents,
        every_look=every,
    )


def _by_block(
    played: Mapping[str, tuple[Outcomes, Outcomes]],
) -> tuple[dict[str, Array], dict[str, NDArray[np.bool_]]]:
    """Arm -> 1 if solved, 0 if not, one row per block, NaN where no trial has ended; and whether its trial broke.

    Rows are in the order in which blocks were planned, if what is said must hold at every look.
    """
    every = [[completed(*one, soon) for one in played.values()] for soon in (False, True)]
    failed, opened = (sheets([replace(one, dose=np.zeros(len(one))) for one in groups])[1] for groups in every)
    rows = failed[0].order if len(failed[0].order) else slice(None)
    broke = {
        arm: one.solved[rows, 0] < other.solved[rows, 0] for arm, one, other in zip(played, failed, opened, strict=True)
    }
    return {
        arm: np.where(broke[arm], np.nan, one.solved[rows, 0]) for arm, one in zip(played, failed, strict=True)
    }, broke


def _arms(
    names: Mapping[str, str],
    solved: Mapping[str, Array],
    broke: Mapping[str, NDArray[np.bool_]],
    agents: int,
    *,
    all_arms: bool,
    every_look: bool,
) -> tuple[ArmEffect, ...]:
    """Success in every arm; its difference from true reports where it may be looked at."""
    compared = [arm for arm in solved if arm != "truth"] if all_arms else []
    changes = {
        arm: bounded_contrast(solved, broke, ((arm, "truth"),), agents=agents, every_look=every_look)
        for arm in compared
    }
    corrected = dict(zip(changes, holm([one.p_value for one in changes.values()]), strict=True))
    return tuple(
        ArmEffect(
            arm=arm,
            condition=names[arm],
            success=share_at_every_look(begun) if every_look else share_of(begun, (), ()),
            change=replace(changes[arm], p_value=corrected[arm]) if arm in changes else None,
        )
        for arm, own in solved.items()
        for begun in [own[broke[arm] | ~np.isnan(own)]]
    )


def _needed(differences: Array, effect: float, agents: int) -> int:
    """Sample size: blocks at which a two-sided test at 5 % / agents detects an effect with a power of 80 %.

    The standard error is that after one more differing pair (Agresti and Min 2005).
    """
    kept = differences[~np.isnan(differences)]
    n, mean = len(kept), float(kept.mean())
    error = math.sqrt((float(np.sum((kept - mean) ** 2)) + 1) / (n - 1) / n)
    reach = normal_quantile(1 - ALPHA / 2 / agents) + normal_quantile(_POWER)
    return math.ceil(n * (reach * error / effect) ** 2)
