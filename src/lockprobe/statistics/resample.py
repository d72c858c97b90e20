"""The cluster bootstrap of a study: whole clusters of trials are drawn with replacement.

A cluster is the trials of equal luck over all p, drawn within their repetition, or all trials of one player.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.outcomes import Outcomes

__all__ = ["RESAMPLES", "Resamples", "drawn_shares", "resample", "times_drawn"]

RESAMPLES = 2000

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


def times_drawn(counted: Outcomes, rng: np.random.Generator, resamples: int = RESAMPLES) -> Array | None:
    """How often each cluster is drawn, shape (resamples, clusters); None if a repetition has a single cluster."""
    cluster, stratum = counted.cluster, counted.stratum
    times = np.zeros((resamples, int(cluster.max(initial=-1)) + 1))
    for number in np.unique(stratum):
        members = np.unique(cluster[stratum == number])
        if len(members) < 2:
            return None
        times[:, members] = rng.multinomial(len(members), np.full(len(members), 1 / len(members)), size=resamples)
    return times


def drawn_shares(times: Array, luck: NDArray[np.int64], column: NDArray[np.intp], happened: NDArray[np.bool_]) -> Array:
    """Shares in every resample, shape (resamples, columns); the observed share where nothing of a column was drawn.

    Args:
        times: How often each cluster was drawn, shape (resamples, clusters).
        luck: The cluster of each trial, shape (trials,).
        column: The column that each trial belongs to, from 0, of the same shape.
        happened: The event, of the same shape.
    """
    present, counts = np.zeros((2, times.shape[1], int(column.max(initial=-1)) + 1))
    np.add.at(present, (luck, column), 1.0)
    np.add.at(counts, (luck, column), happened)
    many = times @ present
    return np.where(many > 0, times @ counts / np.maximum(many, 1), counts.sum(axis=0) / present.sum(axis=0))


def resample(counted: Outcomes, rng: np.random.Generator) -> Resamples:
    """Draw the clusters of one agent's trials with replacement, within every repetition."""
    keys = np.column_stack([counted.dose, counted.repetition])
    kinds, point = np.unique(keys, axis=0, return_inverse=True)
    times = times_drawn(counted, rng)
    if times is None:
        return Resamples(success=np.empty((0, len(kinds))), loop_rate=np.empty((0, len(kinds))))
    return Resamples(
        success=drawn_shares(times, counted.cluster, point.reshape(-1), counted.solved),
        loop_rate=drawn_shares(times, counted.cluster, point.reshape(-1), counted.looped),
    )
