"""Episodes as columns of NumPy, and two sides of them compared: in pairs of equal luck, or over tasks, or one by one.

All of it is a mean of differences over blocks (:mod:`lockprobe.statistics.blocks`): of success in pairs by sign flips,
else by Student's t. Where seeds match a block is a task and a seed, and a pair has equal luck. Where too few do, it is
a task, and its difference that of the means of both sides on it, so that a side with more episodes of easy tasks is not
better for it. On one task, without pairs, each episode is a block. An episode of which nobody says how it ended is
neither a success nor a failure: interval and P value hold whatever it was.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.blocks import FEWEST, Blocks, block_mean, mean_of_blocks
from lockprobe.statistics.broken_trials import bounded
from lockprobe.statistics.outcomes import BlockOrder
from lockprobe.statistics.pairs import mean_over_boxes
from lockprobe.statistics.proportions import Difference

Array = NDArray[np.float64]
Codes = NDArray[np.int64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True, eq=False)
class Episodes:
    """Episodes in the order of the file, one each place of every column.

    Attributes:
        agents, conditions, tasks: Names, as they come; the control is the first condition.
        agent, condition, task: Places of these names.
        luck: Number of its task and seed, from 0 as they come; -1 of an episode without a seed.
        rank: Which it is of several of one agent, condition and luck, from 0.
        solved, score, steps: 1 or 0, from 0 to 1, and steps played; NaN where nobody says.
        actions: What each did, step by step; empty where nobody says.
    """

    agents: Sequence[str]
    conditions: Sequence[str]
    tasks: Sequence[str]
    agent: Codes
    condition: Codes
    task: Codes
    luck: Codes
    rank: Codes
    solved: Array
    score: Array
    steps: Array
    actions: Sequence[Sequence[str]]

    def __len__(self) -> int:
        return len(self.agent)

    @property
    def measures(self) -> dict[str, Array]:
        """What can be compared."""
        known = {"success": self.solved, "score": self.score}
        return {name: values for name, values in known.items() if not np.isnan(values).all()}

    @property
    def cells(self) -> list[tuple[dict[str, Any], Flags]]:
        """The names of each agent and condition, and which episodes are theirs; those that have any."""
        every = ((a, c) for a in range(len(self.agents)) for c in range(len(self.conditions)))
        own = [(a, c, (self.agent == a) & (self.condition == c)) for a, c in every]
        return [({"agent": self.agents[a], "condition": self.conditions[c]}, at) for a, c, at in own if at.any()]

    def pairs(self, first: Flags, second: Flags, other: Codes) -> tuple[Codes, Codes]:
        """The places of the episodes of two sides that are pairs, in the order of luck.

        A pair has equal luck and rank, and is equal in what else differs: the agent, where conditions are compared.
        """
        key = (self.luck * (other.max() + 1) + other) * (self.rank.max() + 1) + self.rank
        one, two = (np.flatnonzero(side & (self.luck >= 0)) for side in (first, second))
        _, i, j = np.intersect1d(key[one], key[two], assume_unique=True, return_indices=True)
        return one[i], two[j]

    def cluster(self, at: Codes, fewest: int) -> Codes:
        """What is independent of episodes: their tasks; of fewer tasks their luck, or each without a seed; from 0."""
        alone = np.where(self.luck >= 0, self.luck, len(self) + np.arange(len(self)))
        return combined((self.task if len(np.unique(self.task[at])) >= fewest else alone)[at])


def combined(*columns: Codes) -> Codes:
    """The combinations of codes, numbered as they come, from 0."""
    found = np.zeros(len(columns[0]), dtype=np.int64)
    for column in columns:  # numbered anew each time, so that no product is too large
        found = np.unique(found * (int(column.max(initial=0)) + 1) + column, return_inverse=True)[1].reshape(-1)
    _, first, found = np.unique(found, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(first))[found.reshape(-1)]


def position(group: Codes) -> Codes:
    """Which each is of its group, from 0."""
    order = np.argsort(group, kind="stable")
    starts, sizes = np.unique(group[order], return_index=True, return_counts=True)[1:]
    return (np.arange(len(group)) - np.repeat(starts, sizes))[np.argsort(order)]


@dataclass(frozen=True, kw_only=True)
class Sides:
    """The episodes of two sides that can be compared.

    Attributes:
        first, second: Places of the episodes of each side; of pairs the two of each, in the order of luck.
        group: The number of the task of every episode and of what sides have in common, such as the agent.
    """

    by: Literal["pairs", "tasks", "episodes"]
    first: Codes
    second: Codes
    group: Codes


def sides(episodes: Episodes, first: Flags, second: Flags, other: Codes) -> Sides:
    """What two sides have in common, which are equal in ``other``: pairs if these have blocks enough, else tasks."""
    group, (one, two) = combined(episodes.task, other), episodes.pairs(first, second, other)
    if len(np.unique(episodes.luck[one])) >= FEWEST:
        return Sides(by="pairs", first=one, second=two, group=group)
    shared = np.isin(group, np.intersect1d(group[first], group[second]))
    one, two = np.flatnonzero(first & shared), np.flatnonzero(second & shared)
    return Sides(by="tasks" if len(episodes.tasks) > 1 else "episodes", first=one, second=two, group=group)


def compare(
    episodes: Episodes, of: Sides, values: Array, *, choices: int = 1, every_look: bool = False
) -> tuple[float, float, Difference]:
    """The means of both sides, and the second minus the first; of nothing where nothing can be compared.

    Interval and P value are corrected for ``choices`` (Bonferroni). With ``every_look`` those of pairs hold however
    often one looks, at whole tasks in the order of the file; of one task at its blocks.
    """
    one, two = values[of.first], values[of.second]
    ends = [(one, two)]
    if np.isnan(one).any() or np.isnan(two).any():
        ends += [(np.where(np.isnan(one), 1 - end, one), np.where(np.isnan(two), end, two)) for end in (0.0, 1.0)]
    marks, found = bool(np.isin(values[~np.isnan(values)], (0, 1)).all()), list[Difference]()
    for low, high in ends:
        apart, block, task = _apart(episodes, of, low, high)
        there, order = ~np.isnan(apart), BlockOrder(plans=((1, len(apart)),)) if every_look else None
        how = "flips" if marks and of.by == "pairs" else "shares" if marks else "scores"
        found.append(_mean(apart[there], block[there], task[there], how, choices, order))
    if of.by == "pairs":
        one, two = (side[~np.isnan(two - one)] for side in (one, two))
    means = [float(np.nanmean(side)) if not np.isnan(side).all() else math.nan for side in (one, two)]
    return means[0], means[1], bounded(*found) if len(found) > 1 else found[0]


def _apart(episodes: Episodes, of: Sides, low: Array, high: Array) -> tuple[Array, Codes, Codes]:
    """The differences of these values of both sides, whose mean is theirs; the block and the task of each."""
    if of.by == "pairs":
        return high - low, episodes.luck[of.first], episodes.task[of.first]
    if of.by == "tasks":
        task = episodes.task[np.unique(of.group, return_index=True)[1]]
        return _means(high, of.group[of.second], len(task)) - _means(low, of.group[of.first], len(task)), task, task
    low, high = low[~np.isnan(low)], high[~np.isnan(high)]
    if min(len(low), len(high)) < FEWEST:
        return np.empty(0), of.first[:0], of.first[:0]
    both = np.r_[low, high] - np.r_[low, high].mean()  # each as much as it moves its side's mean, which cancels in all
    weight = len(both) / np.repeat([-len(low), len(high)], [len(low), len(high)])
    return weight * both, np.arange(len(both)), np.zeros(len(both), dtype=np.int64)


def _means(values: Array, group: Codes, size: int) -> Array:
    """The mean of the values of each group, NaN of one without any."""
    known = ~np.isnan(values)
    counts = np.bincount(group[known], minlength=size)
    found: Array = np.bincount(group[known], values[known], size) / np.where(counts > 0, counts, np.nan)
    return found


def _mean(values: Array, block: Codes, task: Codes, how: str, choices: int, order: BlockOrder | None) -> Difference:
    """The mean of values by block, each of one task, with an interval and a P value that hold over tasks too.

    Both are of sign flips of differences that are -1, 0 or 1 (``flips``), or Student's: of means of these (``shares``)
    one more block is added that differs wholly, while ``scores`` vary by themselves.
    """
    row, column = np.unique(block, return_inverse=True)[1].reshape(-1), position(block)
    table = np.full((int(row.max(initial=-1)) + 1, int(column.max(initial=-1)) + 1), np.nan)
    table[row, column] = values
    box = task[np.unique(block, return_index=True)[1]][: len(table) * (len(np.unique(task)) > 1)].astype(np.str_)
    if how == "flips":
        nobody, place = np.empty((0, 0), dtype=np.str_), np.arange(len(table))
        blocks = Blocks(solved=table, steps=table, person=nobody, box=box, place=place, order=None)
        found = mean_of_blocks(table, blocks, choices=choices)
        if order is not None and found.n:
            each = combined(task if len(box) else block)  # tasks may differ in the effect
            means = _means(values, each, int(each.max()) + 1)[:, None]
            blocks = replace(blocks, place=np.arange(len(means)), order=order)
            found = bounded(found, found, mean_of_blocks(means, blocks, choices=choices))
        return found
    found = block_mean(table, choices=choices, rare=(1e-9, 1e-9) if how == "scores" else None)  # all may be equal
    if found.p_value is not None:
        found = replace(found, p_value=min(1.0, choices * found.p_value))
    return mean_over_boxes(found, np.nanmean(table, axis=1), box, choices=choices) if len(box) else found
