"""Episodes as columns of NumPy, and two sides of them compared: in pairs of equal luck, or over tasks, or one by one.

All of it is a mean of differences over blocks (:mod:`lockprobe.statistics.blocks`), in which every task counts alike:
of success in pairs by sign flips, else by Student's t. Where seeds match a block is a task and a seed, and a pair has
equal luck. Where too few do, it is a task, and its difference that of the means of both sides on it, so that a side
with more episodes of easy tasks is not better for it. On one task, without pairs, each episode is a block. An episode
of which nobody says how it ended is neither a success nor a failure: interval and P value hold whatever it was.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.blocks import FEWEST, block_mean, sign_flip
from lockprobe.statistics.broken_trials import bounded
from lockprobe.statistics.every_look import Numbers, at_every_look
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
    def cells(self) -> list[tuple[dict[str, Any], Flags]]:
        """The names of each agent and condition, and which episodes are theirs; those that have any."""
        every = ((a, c) for a in range(len(self.agents)) for c in range(len(self.conditions)))
        own = [(a, c, (self.agent == a) & (self.condition == c)) for a, c in every]
        return [({"agent": self.agents[a], "condition": self.conditions[c]}, at) for a, c, at in own if at.any()]

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


def means_of(values: Array, group: Codes, size: int = 0) -> Array:
    """The mean of the values of each group, NaN of one without any; of ``size`` groups or more."""
    known = ~np.isnan(values)
    counts = np.bincount(group[known], minlength=size)
    found: Array = np.bincount(group[known], values[known], size) / np.where(counts > 0, counts, np.nan)
    return found


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


def sides(of: Episodes, first: Flags, second: Flags, other: Codes) -> Sides:
    """What two sides have in common, which are equal in ``other``: pairs if these have blocks enough, else tasks.

    A pair has equal luck and rank, and is equal in what else differs: the agent, where conditions are compared.
    """
    group, key = combined(of.task, other), (of.luck * (other.max() + 1) + other) * (of.rank.max() + 1) + of.rank
    one, two = (np.flatnonzero(side & (of.luck >= 0)) for side in (first, second))
    _, i, j = np.intersect1d(key[one], key[two], assume_unique=True, return_indices=True)
    if len(np.unique(of.luck[one[i]])) >= FEWEST:
        return Sides(by="pairs", first=one[i], second=two[j], group=group)
    shared = np.isin(group, np.intersect1d(group[first], group[second]))
    one, two = np.flatnonzero(first & shared), np.flatnonzero(second & shared)
    return Sides(by="tasks" if len(of.tasks) > 1 else "episodes", first=one, second=two, group=group)


def compare(
    of: Episodes, own: Sides, values: Array, *, choices: int = 1, every_look: bool = False
) -> tuple[float, float, Difference]:
    """The means of both sides, and the second minus the first; of nothing where nothing can be compared.

    Interval and P value are corrected for ``choices`` (Bonferroni). With ``every_look`` those of pairs hold however
    often one looks, at whole tasks in the order of the file; of one task at its blocks.
    """
    one, two = values[own.first], values[own.second]
    ends = [(one, two)]
    if np.isnan(np.r_[one, two]).any():
        ends += [(np.where(np.isnan(one), 1 - end, one), np.where(np.isnan(two), end, two)) for end in (0.0, 1.0)]
    marks = bool(np.isin(values[~np.isnan(values)], (0, 1)).all())
    found = [_mean(*_apart(of, own, *end), choices, marks, every_look, own.by == "pairs") for end in ends]
    if own.by == "pairs":
        one, two = one + 0 * two, two + 0 * one  # without what has no other side
    if not found[0].n:
        return math.nan, math.nan, found[0]
    first, second = (np.nanmean(means_of(one, of.task[own.first])), np.nanmean(means_of(two, of.task[own.second])))
    return float(first), float(second), bounded(*found) if len(found) > 1 else found[0]


def _apart(of: Episodes, own: Sides, first: Array, second: Array) -> tuple[Array, Codes, Codes]:
    """The differences of these values of both sides; the block and the task of each."""
    if own.by == "pairs":
        return second - first, of.luck[own.first], of.task[own.first]
    if own.by == "tasks":
        task = of.task[np.unique(own.group, return_index=True)[1]]
        one, two = (means_of(x, own.group[at], len(task)) for x, at in ((first, own.first), (second, own.second)))
        return two - one, task, task
    low, high = first[~np.isnan(first)], second[~np.isnan(second)]
    if min(len(low), len(high)) < FEWEST:
        return np.empty(0), of.task[:0], of.task[:0]
    both = np.r_[low, high] - np.r_[low, high].mean()  # each as much as it moves its side's mean, which cancels in all
    weight = len(both) / np.repeat([-len(low), len(high)], [len(low), len(high)])
    return weight * both, np.arange(len(both)), np.zeros(len(both), dtype=np.int64)


def _mean(values: Array, block: Codes, task: Codes, choices: int, marks: bool, looks: bool, pairs: bool) -> Difference:
    """The mean over tasks of differences in blocks, with an interval and a P value that hold over tasks too.

    Of pairs of ``marks``, which are 0 or 1, the P value is that of sign flips of blocks, else Student's. To means of
    marks one block is added that differs wholly, while scores vary by themselves.
    """
    there = ~np.isnan(values)
    values, block, task = values[there], combined(block[there]), combined(task[there])
    many = np.bincount(task)
    table = np.full((int(block.max(initial=-1)) + 1, int(position(block).max(initial=-1)) + 1), np.nan)
    table[block, position(block)] = values * (len(values) / (len(many) * many[task]))  # every task counts alike
    found: Difference = block_mean(table, choices=choices, rare=None if marks else (1e-9, 1e-9))  # all may be equal
    p_value = sign_flip(means_of(values, block) * np.bincount(block)) if marks and pairs else found.p_value
    found = replace(found, p_value=None if p_value is None else min(1.0, choices * p_value))
    found = mean_over_boxes(found, values, task, choices=choices)
    if looks:  # tasks may differ in the effect
        each = means_of(values, task if len(many) > 1 else block)
        ever: Any = at_every_look([Numbers(values=each, block=np.arange(len(each)))], agents=choices)[0]
        found = bounded(found, found, ever)
    return found
