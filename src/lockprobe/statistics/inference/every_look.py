"""Differences in success that hold at every look, in pairs of trials of equal luck.

They take the place of those of :mod:`lockprobe.statistics.inference.difference` where a study is unfinished, was
extended, or stops when it is decided. What people did is compared as everywhere: they come as they please, so that
their trials have no order.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.outcomes import Outcomes
from lockprobe.statistics.proportions import Paired, Proportion, paired
from lockprobe.statistics.sequential.contrasts import AtEveryLook, Numbers, at_every_look
from lockprobe.statistics.sequential.order import BlockOrder
from lockprobe.statistics.sequential.shares import share_at_every_look


@dataclass(frozen=True, slots=True, kw_only=True)
class Change:
    """The difference in success between a condition and the control, at every look.

    Attributes:
        pairs: The paired difference, with the interval and the P value that hold at every look.
        first, second: Share of the pairs solved under the control, and under the condition.
        course: The estimate after each block.
    """

    pairs: Paired
    first: Proportion
    second: Proportion
    course: AtEveryLook


def changes_at_every_look(control: Outcomes, others: Sequence[Outcomes], *, agents: int = 1) -> tuple[Change, ...]:
    """Success under conditions minus success under the control, judged together.

    Args:
        control: The ended trials of one agent under the control, with the order of its blocks.
        others: Those under each other condition; every one shares a block with the control.
        agents: Number of agents that are judged together.
    """
    order = control.order
    assert order is not None, "trials of a study that is judged at every look"
    pairs = [_in_order(control, one, order) for one in others]
    family = [Numbers(values=solved[:, 1].astype(np.float64) - solved[:, 0], block=block) for block, solved in pairs]
    return tuple(
        Change(
            pairs=replace(paired(solved[:, 0], solved[:, 1]), low=course.low, high=course.high, p_value=course.p_value),
            first=share_at_every_look(solved[:, 0]),
            second=share_at_every_look(solved[:, 1]),
            course=course,
        )
        for (_, solved), course in zip(pairs, at_every_look(family, agents=agents, margin=order.margin), strict=True)
    )


def _in_order(first: Outcomes, second: Outcomes, order: BlockOrder) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """The places of the blocks that both have, ascending, and whether they were solved, shape (pairs, 2)."""
    solved = [
        dict(zip(order.rank(one.repetition, one.trial).tolist(), one.solved.tolist(), strict=True))
        for one in (first, second)
    ]
    block = sorted(solved[0].keys() & solved[1].keys())
    found = np.array([[own[place] for own in solved] for place in block], dtype=np.bool_).reshape(-1, 2)
    return np.array(block, dtype=np.int64), found
