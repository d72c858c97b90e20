"""What a study of controls decides on each agent, from its trials.

:mod:`lockprobe.statistics.why.arms` has the arms, :mod:`lockprobe.statistics.why.mechanism` the rule.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.agent_comparison.paired import Array
from lockprobe.statistics.conditions.design import Design
from lockprobe.statistics.course import is_baseline
from lockprobe.statistics.distributions import normal_quantile
from lockprobe.statistics.idle import never_acted
from lockprobe.statistics.outcomes import ended
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
        p: The rate at which reports were hit, (0, 1].
        conditions: Arm -> the name of its condition.
        solved: Arm -> 1 if solved, 0 if not, NaN where no trial has ended, shape (blocks,).
        broke: Arm -> whether the trial of a block broke, of the same shape.
        box: The box of each block; no rows if all are of one.
        every_look: Whether it holds at every look; blocks are then in the order in which they were planned.
        agents: Number of agents that are judged together, for which the decision is corrected (Bonferroni).
    """

    agent: str
    baseline: bool
    modality: str
    p: float
    conditions: Mapping[str, str]
    solved: Mapping[str, Array]
    broke: Mapping[str, NDArray[np.bool_]]
    box: NDArray[np.str_]
    every_look: bool
    agents: int = 1

    @cached_property
    def decision(self) -> Decision:
        """What they decide."""
        return decide(self.solved, broke=self.broke, box=self.box, agents=self.agents, every_look=self.every_look)

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

    ``cells`` are the trials of each agent under each condition; one in which nothing was changed is no arm.
    """
    found = []
    for agent in design.agents:
        for modality in design.modalities:
            p, names = arms_of(design.shown(modality)) or (0.0, {})
            own = {arm: cells.get((agent, label), ()) for arm, label in names.items()}
            acting = {arm: trials for arm, trials in own.items() if arm == "truth" or not never_acted(trials)}
            solved, broke, box = _by_block(acting, orders.get(agent))
            planned = [solved[arm] for arm in PLANNED if arm in solved]
            if len(planned) == len(PLANNED) and np.count_nonzero(~np.isnan(np.sum(planned, axis=0))) > 1:
                found.append(
                    Why(
                        agent=agent, baseline=is_baseline(design.spec_of(agent)), modality=own["truth"][0].modality,
                        p=p, conditions=names, solved=solved, broke=broke, box=box, every_look=agent in orders,
                    )
                )  # fmt: skip
    sizes = Counter((one.modality, one.baseline) for one in found)
    return tuple(replace(one, agents=sizes[one.modality, one.baseline]) for one in found)


def _by_block(
    trials: Mapping[str, Sequence[Trial]], order: BlockOrder | None
) -> tuple[dict[str, Array], dict[str, NDArray[np.bool_]], NDArray[np.str_]]:
    """The columns ``solved``, ``broke`` and ``box`` of :class:`Why`, of arms with an ended trial."""
    played = {arm: own for arm, own in trials.items() if ended(own)}
    known = {(one.repetition, one.trial): one.box for own in played.values() for one in own}
    lucks = sorted(known, key=lambda luck: int(order.rank(*luck)) if order else luck)
    row = {luck: i for i, luck in enumerate(lucks)}
    solved = {arm: np.full(len(lucks), math.nan) for arm in played}
    broke = {arm: np.zeros(len(lucks), dtype=np.bool_) for arm in played}
    for arm, own in played.items():
        place = [row[one.repetition, one.trial] for one in own]
        broke[arm][place] = [one.ending == "error" for one in own]
        solved[arm][place] = [math.nan if one.ending == "error" else one.solved for one in own]
    boxes = [known[luck] for luck in lucks] if len({*known.values()}) > 1 else []
    return solved, broke, np.array(boxes, dtype=np.str_)
