"""The cluster bootstrap of a study: whole clusters of trials are drawn with replacement.

A cluster is the trials of equal luck over all p, drawn within their repetition, or all trials of one player.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.outcomes import Outcomes

RESAMPLES = 2000

_AT_ONCE = 4_000_000
"""Numbers that are drawn at once, 32 MB."""

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Resamples:
    """Resampled points, aligned with :func:`lockprobe.statistics.outcomes.points`.

    Attributes:
        success: Shares solved, shape (resamples, points); zero rows if a repetition has a single trial.
        loop_rate: Shares with an action loop, of the same shape.
    """

    success: Array
    loop_rate: Array


def drawn_shares(
    counted: Outcomes,
    column: NDArray[np.intp],
    *happened: NDArray[np.bool_],
    rng: np.random.Generator,
    resamples: int = RESAMPLES,
) -> list[Array] | None:
    """Shares of events in every resample, each (resamples, columns); None if a repetition has a single cluster.

    Where nothing of a column was drawn, its observed share stands. Some resamples are drawn at a time, since how often
    each cluster is drawn would take gigabytes for all; the counts are whole numbers, so that no sum depends on it.

    Args:
        counted: The trials.
        column: The column that each trial belongs to, from 0, shape (trials,).
        happened: Whether each event happened in each trial, of the same shape.
        rng: Draws the clusters, repetition by repetition.
        resamples: How many.
    """
    cluster, stratum = counted.cluster, counted.stratum
    strata = [np.unique(cluster[stratum == number]) for number in np.unique(stratum)]
    if any(len(members) < 2 for members in strata):
        return None
    shape = (1 + len(happened), int(cluster.max(initial=-1)) + 1, int(column.max(initial=-1)) + 1)
    tables, drawn = np.zeros(shape), np.zeros((shape[0], resamples, shape[2]))
    for table, event in zip(tables, (np.ones(len(column)), *happened), strict=True):
        np.add.at(table, (cluster, column), event)
    for members in strata:
        own, even, rows = tables[:, members], np.full(len(members), 1 / len(members)), max(1, _AT_ONCE // len(members))
        for first in range(0, resamples, rows):
            size = min(rows, resamples - first)
            times = rng.multinomial(len(members), even, size=size).astype(np.float64)
            drawn[:, first : first + size] += times @ own
    totals = tables.sum(axis=1)
    return [
        np.where(drawn[0] > 0, many / np.maximum(drawn[0], 1), total / totals[0])
        for many, total in zip(drawn[1:], totals[1:], strict=True)
    ]


def resample(counted: Outcomes, rng: np.random.Generator) -> Resamples:
    """Draw the clusters of one agent's trials with replacement, within every repetition."""
    keys = np.column_stack([counted.dose, counted.repetition])
    kinds, point = np.unique(keys, axis=0, return_inverse=True)
    shares = drawn_shares(counted, point.reshape(-1), counted.solved, counted.looped, rng=rng)
    success, loop_rate = shares or np.empty((2, 0, len(kinds)))
    return Resamples(success=success, loop_rate=loop_rate)
