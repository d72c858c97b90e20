"""What a study of controls decides on each agent, from its trials.

:mod:`lockprobe.statistics.why.arms` has the arms, :mod:`lockprobe.statistics.why.mechanism` the rule.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np

from lockprobe.statistics.blocks import Blocks, blocks_of
from lockprobe.statistics.conditions.design import Design
from lockprobe.statistics.contrast import Cells
from lockprobe.statistics.course import is_baseline
from lockprobe.statistics.distributions import normal_quantile
from lockprobe.statistics.idle import never_acted
from lockprobe.statistics.proportions import ALPHA
from lockprobe.statistics.why.arms import PLANNED, arms_of
from lockprobe.statistics.why.mechanism import MARGIN, Decision, decide

_POWER = 0.8
"""The power for which the needed blocks are computed."""


@dataclass(frozen=True, kw_only=True)
class Why:
    """The arms of one agent that is shown the box in one way, and what they decide.

    Attributes:
        p: The rate at which reports were hit, (0, 1].
        conditions: Arm -> the name of its condition, of arms in which something was changed and a trial has ended.
        blocks: Success in each arm.
        agents: Number of agents that are judged together, for which the decision is corrected (Bonferroni).
    """

    agent: str
    baseline: bool
    modality: str
    p: float
    conditions: Mapping[str, str]
    blocks: Blocks
    agents: int = 1

    @cached_property
    def decision(self) -> Decision:
        """What they decide."""
        return decide(self.blocks, agents=self.agents)

    @property
    def needed(self) -> int:
        """Blocks at which a two-sided test detects a change of the margin with a power of 80 %.

        The standard error is that after one more differing pair (Agresti and Min 2005).
        """
        differences = self.blocks.solved["lie"] - self.blocks.solved["truth"]
        kept = differences[~np.isnan(differences)]
        n, mean = len(kept), float(kept.mean())
        error = math.sqrt((float(np.sum((kept - mean) ** 2)) + 1) / (n - 1) / n)
        reach = normal_quantile(1 - ALPHA / 2 / self.agents) + normal_quantile(_POWER)
        return math.ceil(n * (reach * error / MARGIN) ** 2)


def whys(cells: Cells, design: Design) -> tuple[Why, ...]:
    """What every agent of a study of controls shows; of those that have two blocks or more with all planned arms.

    In each modality the agents that the study is about are one family, and baselines another. Those that play alike
    count too: that reports change their success by less than the margin is a conclusion. An arm in which nothing was
    changed is left out.
    """
    found = []
    for agent, modality in product(design.agents, design.modalities):
        p, names = arms_of(design.shown(modality)) or (0.0, {})
        own = {arm: cells[agent, label] for arm, label in names.items() if (agent, label) in cells}
        own = {
            arm: one for arm, one in own.items() if len(one.ended) and (arm == "truth" or not never_acted(one.trials))
        }
        if own.keys() >= {*PLANNED}:
            blocks = blocks_of(own)
            if np.count_nonzero(~np.isnan([blocks.solved[arm] for arm in PLANNED]).any(axis=0)) > 1:
                found.append(
                    Why(
                        agent=agent, baseline=is_baseline(design.spec_of(agent)),
                        modality=own["truth"].trials[0].modality, p=p, conditions={arm: names[arm] for arm in own},
                        blocks=blocks,
                    )
                )  # fmt: skip
    sizes = Counter((one.modality, one.baseline) for one in found)
    return tuple(replace(one, agents=sizes[one.modality, one.baseline]) for one in found)
