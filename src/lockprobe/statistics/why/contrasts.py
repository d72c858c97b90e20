"""What a study of controls decides on each agent, from its trials.

:mod:`lockprobe.statistics.why.arms` has the arms, :mod:`lockprobe.statistics.why.mechanism` the rule.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.agent_comparison.paired import Array, sheets
from lockprobe.statistics.broken_trials import completed
from lockprobe.statistics.conditions.design import Design
from lockprobe.statistics.course import is_baseline
from lockprobe.statistics.distributions import normal_quantile
from lockprobe.statistics.idle import never_acted
from lockprobe.statistics.outcomes import Outcomes, boxes_of_all, broken_off, outcomes
from lockprobe.statistics.proportions import ALPHA
from lockprobe.statistics.sequential.order import NO_ORDERS, BlockOrder
from lockprobe.statistics.why.arms import PLANNED, arms_of
from lockprobe.statistics.why.mechanism import MARGIN, Decision, decide
from lockprobe.trial.record import Trial

_POWER = 0.8
"""The power for which the needed blocks are computed."""


@dataclass(frozen=True, kw_only=True)
class Why:
    """The arms of one agent that is shown the box in one way, and what they decide.

    Attributes:
        agent: Its name, or its spec if it has none.
        modality: How the box was shown.
        p: The rate at which reports were hit, (0, 1].
        conditions: Arm -> the name of its condition.
        solved: Arm -> 1 if solved, 0 if not, NaN where no trial has ended, shape (blocks,).
        broke: Arm -> whether the trial of a block broke, of the same shape.
        agents: Number of agents that are judged together, for which the decision is corrected (Bonferroni).
        every_look: Whether it holds at every look; blocks are then in the order in which they were planned.
        decision: What they decide.
    """

    agent: str
    modality: str
    p: float
    conditions: Mapping[str, str]
    solved: Mapping[str, Array]
    broke: Mapping[str, NDArray[np.bool_]]
    agents: int
    every_look: bool
    decision: Decision

    @property
    def needed(self) -> int:
        """Blocks at which a two-sided test detects a change of the margin with a power of 80 %.

        The standard error is that after one more differing pair (Agresti and Min 2005).
        """
        differences = self.solved["lie"] - self.solved["truth"]
        kept = differences[~np.isnan(differences)]
        n, mean = len(kept), float(kept.mean())
        error = math.sqrt((float(np.sum((kept - mean) ** 2)) + 1) / (n - 1) / n)
        reach = normal_quantile(1 - ALPHA / 2 / self.agents) + normal_quantile(_POWER)
        return math.ceil(n * (reach * error / MARGIN) ** 2)


def whys(
    cells: Mapping[tuple[str, str], Sequence[Trial]], design: Design, orders: Mapping[str, BlockOrder] = NO_ORDERS
) -> tuple[Why, ...]:
    """What every agent of a study of controls shows; of those that have two blocks or more with all planned arms.

    In each modality the agents that the study is about are one family, and baselines another. Those that play alike
    count too: that reports change their success by less than the margin is a conclusion.

    Args:
        cells: The trials of each agent under each condition; one in which nothing was changed is no arm.
        design: The design of the study.
        orders: Agent -> the order of its blocks, of agents of which everything must hold at every look.
    """
    found = []
    for agent in design.agents:
        for modality in design.modalities:
            p, names = arms_of(design.shown(modality)) or (0.0, {})
            own = {arm: cells.get((agent, label), ()) for arm, label in names.items()}
            acting = {
                arm: trials for arm, trials in own.items() if trials and (arm == "truth" or not never_acted(trials))
            }
            solved, broke, box = by_block(acting, orders.get(agent))
            planned = [solved[arm] for arm in PLANNED if arm in solved]
            if planned[len(PLANNED) - 1 :] and np.count_nonzero(~np.isnan(np.sum(planned, axis=0))) > 1:
                shown = acting["truth"][0].modality
                found.append(
                    ((shown, is_baseline(design.spec_of(agent))), (agent, shown, p, names, solved, broke, box))
                )
    sizes = Counter(family for family, _ in found)
    return tuple(
        Why(
            agent=agent,
            modality=modality,
            p=p,
            conditions=names,
            solved=solved,
            broke=broke,
            agents=sizes[family],
            every_look=agent in orders,
            decision=decide(solved, broke=broke, box=box, agents=sizes[family], every_look=agent in orders),
        )
        for family, (agent, modality, p, names, solved, broke, box) in found
    )


def by_block(
    trials: Mapping[str, Sequence[Trial]], order: BlockOrder | None = None
) -> tuple[dict[str, Array], dict[str, NDArray[np.bool_]], NDArray[np.str_]]:
    """The columns ``solved`` and ``broke`` of :class:`Why`, of arms with an ended trial, and the box of each block.

    There are no boxes where all trials are of one.
    """
    played: dict[str, tuple[Outcomes, Outcomes]] = {
        arm: (ended, broken_off(own, order=order))
        for arm, own in trials.items()
        if len(ended := outcomes(own, order=order))
    }
    every = [[completed(*one, soon) for one in played.values()] for soon in (False, True)]
    failed, opened = (sheets([replace(one, dose=np.zeros(len(one))) for one in groups])[1] for groups in every)
    solved, broke = {}, {}
    for arm, one, other in zip(played, failed, opened, strict=True):
        broke[arm] = one.solved[:, 0] < other.solved[:, 0]
        solved[arm] = np.where(broke[arm], np.nan, one.solved[:, 0])
    return solved, broke, boxes_of_all([one for both in played.values() for one in both if len(one)])
