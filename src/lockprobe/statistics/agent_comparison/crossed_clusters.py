"""Differences between an agent and people, with standard errors clustered two ways: by luck and by person.

An agent's trials of one block of luck are correlated over p. A person's boxes are correlated too, and lie in several
blocks. So neither blocks nor people are exchangeable, and Student's t uses the two-way clustered variance. At a single
p no two people share a luck, so whole people are exchanged.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.agent_comparison.paired import (
    Array,
    BlockMean,
    Sheet,
    block_mean,
    by_cluster,
    half_width,
    sign_flip,
)
from lockprobe.statistics.clustered import alike_weights, two_way_variance
from lockprobe.statistics.distributions import student_tails
from lockprobe.statistics.proportions import ALPHA, LEVEL
from lockprobe.statistics.rare_long_trials import RareBlock

FEWEST = 7
"""The fewest people, and the fewest blocks of luck, for a test: a variance from fewer is too uncertain."""

_TIE = 1e-9
_Labels = NDArray[Any]


def people_of(laid: tuple[Sheet, Sheet]) -> _Labels | None:
    """The person of each trial, shape (blocks, p); None if neither of the two agents is people."""
    return next((sheet.person for sheet in laid if sheet.person.size), None)


def crossed_mean(
    values: Array, luck: _Labels, person: _Labels, *, unit: float | None = None, rare: RareBlock | None = None
) -> BlockMean:
    """The mean of trials, clustered by luck and by person, with a t-test of mean 0.

    The P value is None with too few people or blocks. If people have unequally many trials, the interval also holds
    that of the mean over people, and the P value is the larger: a conclusion must hold with every trial and with every
    person counted alike (:func:`lockprobe.statistics.clustered.crossed_proportion`).

    Args:
        values: One value per trial, shape (trials,).
        luck: Its block of luck, of the same shape.
        person: Its person, of the same shape.
        unit: The largest value of a single trial; the variance is then widened as if one trial more differed, as in
            :func:`lockprobe.statistics.agent_comparison.paired.block_mean`.
        rare: Of steps, how far a rare block, or person, may lie from the mean.
    """
    n = len(values)
    if not n:
        return BlockMean(value=math.nan, low=None, high=None, p_value=None, pairs=0, blocks=0)
    made = [
        _clustered_mean(mean, weight * (values - mean), luck, person, unit=unit, pairs=n, most=unit, rare=rare)
        for weight in (np.ones(n), alike_weights(person))
        for mean in [float((weight * values).mean())]
    ]
    return _held_by_both(*made)


def _held_by_both(pooled: BlockMean, alike: BlockMean) -> BlockMean:
    """The pooled mean, with an interval that holds both and the larger P value; 1 if the signs differ."""
    if pooled.low is None or pooled.high is None or alike.low is None or alike.high is None:
        return pooled
    tested = pooled.p_value
    if tested is not None and alike.p_value is not None:
        tested = max(tested, alike.p_value) if pooled.value * alike.value > 0 else 1.0
    return replace(pooled, low=min(pooled.low, alike.low), high=max(pooled.high, alike.high), p_value=tested)


def crossed_change(low: Array, high: Array, person: tuple[_Labels, _Labels], *, choices: int = 1) -> BlockMean:
    """How much the difference of two agents' success changes from the lowest p to a higher one.

    Args:
        low: Differences of the two agents at the lowest p by block of luck, shape (blocks,), in [-1, 1].
        high: The same at the higher p.
        person: The person of each, at the lowest p and at the higher, of the same shape.
        choices: Number of changes examined; the interval has the level 1 - 0.05 / choices.
    """
    blocks = np.arange(len(low))
    residuals = np.concatenate([low.mean() - low, high - high.mean()])
    return _clustered_mean(
        float(high.mean() - low.mean()),
        residuals,
        np.concatenate([blocks, blocks]),
        np.concatenate(person),
        unit=1.0,
        pairs=len(low),
        most=2.0,
        level=1 - ALPHA / choices,
    )


def _clustered_mean(
    value: float,
    residuals: Array,
    luck: _Labels,
    person: _Labels,
    *,
    unit: float | None,
    pairs: int,
    most: float | None,
    rare: RareBlock | None = None,
    level: float = LEVEL,
) -> BlockMean:
    blocks, people = len(np.unique(luck)), len(np.unique(person))
    none = BlockMean(value=value, low=None, high=None, p_value=None, pairs=pairs, blocks=blocks)
    if min(blocks, people) < 2:
        return none
    spread = two_way_variance(residuals, luck, person)
    if spread < _TIE and unit is None:
        return none
    widest = float(max(np.unique(of, return_counts=True)[1].max() for of in (luck, person)))
    if unit is not None and rare is None:
        spread += unit**2 * (widest**2 if spread < _TIE else widest)
    se, ends, fewest = math.sqrt(spread) / pairs, math.inf if most is None else most, min(blocks, people)
    if rare is None:
        half = half_width(se, fewest, level)
        low, high = value - half, value + half
        tested = float(student_tails(value / se, fewest - 1))
    else:
        share = widest / pairs
        low, high = rare.interval(value, se, fewest, share=share, level=level)
        tested = rare.p_value(value, se, fewest, share=share)
    return replace(none, low=max(-ends, low), high=min(ends, high), p_value=tested if fewest >= FEWEST else None)


def at_one_p(values: Array, person: _Labels, *, unit: float | None = None, rare: RareBlock | None = None) -> BlockMean:
    """The mean difference at one p, with an exchange test that swaps the agents within whole people.

    Args:
        values: Differences, whole numbers, shape (pairs,).
        person: The person of each, of the same shape.
        unit: The largest difference of a single trial.
        rare: Of steps, how far a rare person may lie from the mean.

    If people have unequally many trials, a conclusion must also hold with every person counted alike.
    """
    rows = by_cluster(values, np.unique(person, return_inverse=True)[1].reshape(-1))
    found = block_mean(rows, unit=unit, rare=rare)
    sizes = np.sum(~np.isnan(rows), axis=1)
    if not len(sizes) or np.ptp(sizes) == 0:
        return found
    means = np.nanmean(rows, axis=1)
    alike = block_mean(means[:, None], unit=unit, rare=rare)
    return _held_by_both(found, replace(alike, p_value=sign_flip(means * math.lcm(*sizes.tolist()))))
