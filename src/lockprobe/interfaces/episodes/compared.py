"""Two sides of episodes compared: in pairs of equal task and seed where these match, else over tasks, else one by one.

All of it is a mean of differences over blocks (:mod:`lockprobe.statistics.blocks`): of success in pairs by sign flips,
of scores and of tasks by Student's t. Where seeds match a block is a task
and a seed, and a pair has equal luck. Where too few do, a block is a task, and its difference that of the means of both
sides on it, so that a side with more episodes of easy tasks is not better for it. On one task, without pairs, episodes
are independent. An episode of which nobody says how it ended is neither a success nor a failure: interval and P value
hold whatever it was.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from lockprobe.interfaces.episodes.frame import Array, Codes, Episodes, Flags, position
from lockprobe.statistics.blocks import FEWEST, Blocks, block_mean, mean_of_blocks
from lockprobe.statistics.broken_trials import bounded
from lockprobe.statistics.clustered import clustered_difference
from lockprobe.statistics.outcomes import BlockOrder
from lockprobe.statistics.pairs import mean_over_boxes
from lockprobe.statistics.proportions import ALPHA, Difference

_LEAST = 1e-9
"""The least error of a mean of scores, which may all be equal."""


@dataclass(frozen=True, kw_only=True)
class Sides:
    """The episodes of two sides that can be compared.

    Attributes:
        by: What a difference is of.
        first, second: Places of the episodes of each side; of pairs the two of each, in the order of luck.
        key: The number of the task of every episode and of what sides have in common, such as the agent.
        tasks: The number of the task for each such number.
    """

    by: Literal["pairs", "tasks", "episodes"]
    first: Codes
    second: Codes
    key: Codes
    tasks: Codes


def sides(episodes: Episodes, first: Flags, second: Flags, other: Codes) -> Sides:
    """What two sides have in common, which are equal in ``other``: pairs if these have blocks enough, else tasks."""
    many = int(other.max()) + 1
    key, tasks = episodes.task * many + other, np.repeat(np.arange(len(episodes.tasks)), many)
    one, two = episodes.pairs(first, second, other)
    if len(np.unique(episodes.luck[one])) >= FEWEST:
        return Sides(by="pairs", first=one, second=two, key=key, tasks=tasks)
    shared = np.isin(key, np.intersect1d(key[first], key[second]))
    one, two = np.flatnonzero(first & shared), np.flatnonzero(second & shared)
    return Sides(by="tasks" if len(episodes.tasks) > 1 else "episodes", first=one, second=two, key=key, tasks=tasks)


def compare(
    episodes: Episodes, of: Sides, values: Array, *, choices: int = 1, every_look: bool = False
) -> tuple[float, float, Difference]:
    """The means of both sides, and the second minus the first; of nothing where nothing can be compared.

    Interval and P value are corrected for ``choices`` (Bonferroni). With ``every_look`` both hold however often one
    looks, at blocks in the order of the file.
    """
    one, two = values[of.first], values[of.second]
    ends = [(one, two)]
    if np.isnan(one).any() or np.isnan(two).any():
        ends += [(np.where(np.isnan(one), 1 - end, one), np.where(np.isnan(two), end, two)) for end in (0.0, 1.0)]
    marks = bool(np.isin(values[~np.isnan(values)], (0, 1)).all())
    found = [_change(episodes, of, low, high, choices, marks=marks, every_look=every_look) for low, high in ends]
    if of.by == "pairs":
        one, two = (side[~np.isnan(two - one)] for side in (one, two))
    means = [float(np.nanmean(side)) if not np.isnan(side).all() else math.nan for side in (one, two)]
    return means[0], means[1], bounded(*found) if len(found) > 1 else found[0]


def _change(
    episodes: Episodes, of: Sides, low: Array, high: Array, choices: int, *, marks: bool, every_look: bool
) -> Difference:
    """The mean difference over blocks, of these values of both sides; ``marks`` are all 0 or 1."""
    if of.by == "episodes":
        low, high = low[~np.isnan(low)], high[~np.isnan(high)]
        both, later = np.r_[low, high], np.repeat([False, True], [len(low), len(high)])
        if min(len(low), len(high)) < FEWEST:
            return Difference(value=math.nan)
        if marks:
            alone = np.arange(len(both))
            return replace(clustered_difference(both, later, alone, alone, choices=choices), n=len(both))
        return _welch(low, high, choices)
    if of.by == "pairs":
        apart, block, task = high - low, episodes.luck[of.first], episodes.task[of.first]
    else:
        apart = _means(high, of.key[of.second], len(of.tasks)) - _means(low, of.key[of.first], len(of.tasks))
        block = task = of.tasks
    there = ~np.isnan(apart)
    apart, block, task = apart[there], block[there], task[there]
    if marks and of.by == "pairs":
        return _flipped(apart, block, task, choices, every_look=every_look)
    return _student(apart, block, task, choices, marks=marks)


def _welch(low: Array, high: Array, choices: int) -> Difference:
    from scipy.stats import ttest_ind

    found = ttest_ind(high, low, equal_var=False)
    ends = found.confidence_interval(1 - ALPHA / choices)
    p_value, n = min(1.0, choices * float(found.pvalue)), len(low) + len(high)
    return Difference(value=float(high.mean() - low.mean()), low=ends.low, high=ends.high, p_value=p_value, n=n)


def _laid(values: Array, block: Codes) -> tuple[Array, Codes]:
    """Values by block (rows), one beside the other, NaN where a block has fewer; the first place of each block."""
    row, column = np.unique(block, return_inverse=True)[1].reshape(-1), position(block)
    table = np.full((int(row.max(initial=-1)) + 1, int(column.max(initial=-1)) + 1), np.nan)
    table[row, column] = values
    return table, np.unique(block, return_index=True)[1]


def _flipped(apart: Array, block: Codes, task: Codes, choices: int, *, every_look: bool) -> Difference:
    """The mean of differences that are -1, 0 or 1, by sign flips of blocks, each of one task."""
    table, first = _laid(apart, block)
    blocks = Blocks(
        solved=table,
        steps=table,
        person=np.empty((0, 0), dtype=np.str_),
        box=task[first if len(np.unique(task)) > 1 else first[:0]].astype(np.str_),
        place=np.arange(len(table)),
        order=BlockOrder(plans=((1, len(table)),)) if every_look else None,
    )
    return mean_of_blocks(table, blocks, choices=choices)


def _student(values: Array, block: Codes, task: Codes, choices: int = 1, *, marks: bool) -> Difference:
    """The mean of values, with Student's interval and P value over blocks, each of one task, and over tasks.

    Of shares one more block is added that differs wholly; scores vary by themselves.
    """
    table, first = _laid(values, block)
    found = block_mean(table, choices=choices, rare=None if marks else (_LEAST, _LEAST))
    if found.p_value is not None:
        found = replace(found, p_value=min(1.0, choices * found.p_value))
    if not found.n or len(np.unique(task)) < 2:
        return found
    return mean_over_boxes(found, np.nanmean(table, axis=1), task[first], choices=choices)


def _means(values: Array, key: Codes, size: int) -> Array:
    """The mean of the values of each number, NaN of one without any."""
    known = ~np.isnan(values)
    counts = np.bincount(key[known], minlength=size)
    found: Array = np.bincount(key[known], values[known], size) / np.where(counts > 0, counts, np.nan)
    return found


def mean_of(episodes: Episodes, at: Flags, values: Array) -> Difference:
    """The mean of some episodes, such as their score, with an interval over luck and tasks, within [0, 1]."""
    own = np.flatnonzero(at & ~np.isnan(values))
    found = _student(values[own], episodes.cluster(own, len(episodes) + 1), episodes.task[own], marks=False)
    low, high = (end if end is None else min(1.0, max(0.0, end)) for end in (found.low, found.high))
    return replace(found, low=low, high=high, p_value=None)
