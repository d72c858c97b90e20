"""The bootstrap of a study: what its points would be had other trials been drawn.

A trial shares its luck (labels, flips, draws) with the same trial of the same repetition at every other p. Those
trials are therefore drawn together, as one cluster, within their repetition.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lockprobe.analysis.behaviour import has_loop
from lockprobe.analysis.outcomes import Point
from lockprobe.record import Trial

__all__ = ["RESAMPLES", "Resamples", "resample"]

RESAMPLES = 2000

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Resamples:
    """Resampled points, aligned with the points they were made for.

    Attributes:
        success: Shares solved, shape (resamples, points); no rows if a repetition has a single trial.
        loop_rate: Shares with an action loop, of the same shape.
    """

    success: Array
    loop_rate: Array


def resample(trials: Sequence[Trial], points: Sequence[Point], rng: np.random.Generator) -> Resamples:
    """Draw clusters of trials with replacement, within every repetition.

    Args:
        trials: The trials of one agent that ended as solved or out of budget.
        points: The points they make, each with at least one trial.
        rng: The stream of the bootstrap.
    """
    shape = (RESAMPLES, len(points))
    success, loop_rate = np.empty(shape), np.empty(shape)
    for repetition in sorted({point.repetition for point in points}):
        members = [trial for trial in trials if trial.repetition == repetition]
        clusters = {number: i for i, number in enumerate(sorted({trial.trial for trial in members}))}
        if len(clusters) < 2:
            return Resamples(success=np.empty((0, len(points))), loop_rate=np.empty((0, len(points))))
        times = rng.multinomial(len(clusters), np.full(len(clusters), 1 / len(clusters)), size=RESAMPLES)
        for column, point in enumerate(points):
            if point.repetition != repetition:
                continue
            present, solved, looping = np.zeros((3, len(clusters)))
            for trial in members:
                if trial.p == point.p:
                    place = clusters[trial.trial]
                    present[place], solved[place], looping[place] = 1.0, trial.solved, has_loop(trial)
            n = times @ present
            success[:, column] = np.where(n > 0, times @ solved / np.maximum(n, 1), point.success)
            loop_rate[:, column] = np.where(n > 0, times @ looping / np.maximum(n, 1), point.loop_rate)
    return Resamples(success=success, loop_rate=loop_rate)
