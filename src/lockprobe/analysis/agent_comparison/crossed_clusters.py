"""Differences between an agent and people, with trials clustered by luck and by person.

An agent's trials of one block of luck are alike over p, and so are a person's boxes, which lie in several blocks. So
neither whole blocks nor whole people may be exchanged; Student's t is used on a variance that counts both. At a single
p no two people share a luck, so that whole people can be exchanged.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockprobe.analysis.agent_comparison.paired import Array, BlockMean, Sheet, block_mean, by_cluster, half_width
from lockprobe.analysis.clustered import two_way_variance

__all__ = ["FEWEST", "at_one_p", "crossed_change", "crossed_mean", "people_of"]

FEWEST = 7
"""People, and blocks of luck, below which nothing is tested: a variance from so few is too uncertain."""

_TIE = 1e-9
_Labels = NDArray[Any]


def people_of(laid: tuple[Sheet, Sheet]) -> _Labels | None:
    """The person of each trial, where one of two agents is people; shape (blocks, p)."""
    return next((sheet.person for sheet in laid if sheet.person.size), None)


def crossed_mean(values: Array, luck: _Labels, person: _Labels, *, unit: float | None = None) -> BlockMean:
    """The mean of trials, clustered by luck and by person, with Student's p-value that it is 0.

    The p-value is None with too few people or blocks.

    Args:
        values: One for each trial, shape (trials,).
        luck: Its block of luck, of the same shape.
        person: Its person, of the same shape.
        unit: The largest value of a single trial; the variance is then widened as if one trial more differed, as in
            :func:`lockprobe.analysis.agent_comparison.paired.block_mean`.
    """
    n = len(values)
    value = float(values.mean()) if n else math.nan
    return _clustered_mean(value, values - value, luck, person, unit=unit, pairs=n, most=unit)


def crossed_change(low: Array, high: Array, person: tuple[_Labels, _Labels]) -> BlockMean:
    """Mean difference of success at a higher p less that at the lowest, in points of a share.

    Args:
        low: Differences of two agents at the lowest p, by block of luck, shape (blocks,).
        high: The same at the higher p.
        person: The person of each, at the lowest p and at the higher, of the same shape.
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
) -> BlockMean:
    blocks, people = len(np.unique(luck)), len(np.unique(person))
    none = BlockMean(value=value, low=None, high=None, p_value=None, pairs=pairs, blocks=blocks)
    if min(blocks, people) < 2:
        return none
    spread = two_way_variance(residuals, luck, person)
    if spread < _TIE and unit is None:
        return none
    if unit is not None:
        widest = float(max(np.unique(of, return_counts=True)[1].max() for of in (luck, person)))
        spread += unit**2 * (widest**2 if spread < _TIE else widest)
    from scipy.stats import t

    se, ends = math.sqrt(spread) / pairs, math.inf if most is None else most
    half, fewest = half_width(se, min(blocks, people)), min(blocks, people)
    tested = 2 * float(t.sf(abs(value) / se, fewest - 1)) if fewest >= FEWEST else None
    return replace(none, low=max(-ends, value - half), high=min(ends, value + half), p_value=tested)


def at_one_p(values: Array, person: _Labels, *, unit: float | None = None) -> BlockMean:
    """The mean difference at one p, where no two people share a luck: agents are exchanged within whole people.

    Args:
        values: Differences, whole numbers, shape (pairs,).
        person: The person of each, of the same shape.
        unit: The largest difference of a single trial.
    """
    return block_mean(by_cluster(values, np.unique(person, return_inverse=True)[1].reshape(-1)), unit=unit)
