"""Observed minus expected events, step by step and summed over clusters of luck.

Log-rank and Mantel-Haenszel tests add up, over steps, how far the events with some feature lie from those to be
expected had all running trials been alike. Trials of equal repetition and trial share their luck over all p, so the
differences are summed per cluster, and it is the clusters, which are independent, whose mean is held against nought
(Hotelling's test; with one column Student's t). This is the robust variance of Lin and Wei (1989).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lockprobe.analysis.outcomes import Outcomes

__all__ = ["cluster_sums", "clusters", "grid", "p_value", "scores"]

Array = NDArray[np.float64]


def grid(last: NDArray[np.int64], happened: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Who runs at each step from 1 and whose event it is, both 0 or 1 of shape (trials, steps).

    Args:
        last: The step of the event, or the last one without it, shape (trials,).
        happened: Whether it was an event, of the same shape.
    """
    step = np.arange(1, int(last.max(initial=0)) + 1)
    event = (last[:, None] == step) & happened[:, None]
    return (last[:, None] >= step).astype(np.float64), event.astype(np.float64)


def clusters(outcomes: Outcomes) -> NDArray[np.int64]:
    """One number per repetition and trial, the same over all p."""
    luck = np.stack([outcomes.repetition, outcomes.trial], axis=1)
    return np.unique(luck, axis=0, return_inverse=True)[1].reshape(-1)


def scores(x: Array, event: Array, running: Array, stratum: NDArray[np.int64]) -> Array:
    """What each trial adds to observed minus expected.

    Args:
        x: What is compared, shape (columns, trials, steps); one step stands for all.
        event: Shape (trials, steps).
        running: Shape (trials, steps).
        stratum: From 0, shape (trials,).

    Returns:
        Shape (trials, columns). Over a stratum they sum to the events with x less those expected.
    """
    member = (stratum == np.arange(int(stratum.max(initial=-1)) + 1)[:, None]).astype(np.float64)
    n = np.maximum(member @ running, 1.0)
    ahead = x - (member @ (x * running) / n)[:, stratum]
    expected: Array = (member @ event / n)[stratum]
    found: Array = np.sum(running * ahead * (event - expected), axis=2)
    return found.T


def cluster_sums(score: Array, cluster: NDArray[np.int64]) -> Array:
    """Scores by cluster, shape (clusters, columns). Rounding noise is not evidence."""
    sums = np.zeros((int(cluster.max(initial=-1)) + 1, score.shape[1]))
    np.add.at(sums, cluster, score)
    return np.round(sums, 10)


def p_value(sums: Array) -> float | None:
    """Whether the mean over clusters is nought (Hotelling); None where the clusters are too few or all alike."""
    from scipy.stats import f

    if len(sums) < 2:
        return None
    if not sums.any():
        return 1.0
    mean, covariance = sums.mean(axis=0), np.atleast_2d(np.cov(sums.T))
    columns = int(np.linalg.matrix_rank(covariance, hermitian=True))
    free = len(sums) - columns
    if columns == 0 or free < 1:
        return None
    squared = len(sums) * float(mean @ np.linalg.pinv(covariance, hermitian=True) @ mean)
    return float(f.sf(squared * free / (columns * (len(sums) - 1)), columns, free))
