"""Observed minus expected events by step, with a variance clustered by luck: the core of log-rank tests.

A log-rank test sums, over steps, how far the events with a feature exceed those expected if all trials at risk were
alike. Trials of equal repetition and trial share their luck over all p. So the differences are
summed per cluster, and their variance between clusters is the robust variance of Lin and Wei (1989), made unbiased
for few running trials.

Rejections at .05 under the null hypothesis, in 1500 studies of 7 p x 30 trials with luck shared over p by none and by
half of the trials: loop onset .047 and .045 with Student's t, .056 and .056 with chi-squared.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.distributions import chi_squared_tail, student_tails
from lockprobe.statistics.proportions import ALPHA

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Excess:
    """Observed minus expected events, with their clustered covariance.

    Attributes:
        total: Observed minus expected, shape (columns,).
        covariance: Its covariance between clusters of luck, shape (columns, columns).
        clusters: Number of clusters of luck.
    """

    total: Array
    covariance: Array
    clusters: int

    @property
    def p_value_t(self) -> float | None:
        """Two-sided P value of Student's t over clusters, for the first column; larger than :attr:`p_value`.

        None with six clusters or fewer: the statistic never exceeds their number, so the test could never reject.
        """
        variance = float(self.covariance[0, 0])
        if self.clusters < 2 or student_tails(self.clusters**0.5, self.clusters - 1) >= ALPHA:
            return None
        if variance == 0:
            return 1.0
        return float(student_tails(float(self.total[0]) / variance**0.5, self.clusters - 1))

    @property
    def direction(self) -> int:
        """1 if there are more events with the first feature than expected, -1 if fewer, else 0."""
        return int(np.sign(self.total[0]))

    @property
    def p_value(self) -> float | None:
        """Two-sided chi-squared score test; 1 if all trials are alike; None with too few clusters ever to reject."""
        columns = int(np.linalg.matrix_rank(self.covariance, hermitian=True))
        if chi_squared_tail(self.clusters, max(1, columns)) >= ALPHA:
            return None
        if columns == 0:
            return 1.0
        beyond = float(self.total @ np.linalg.pinv(self.covariance, hermitian=True) @ self.total)
        return chi_squared_tail(beyond, columns)


def grid(last: NDArray[np.int64], happened: NDArray[np.bool_]) -> tuple[Array, Array]:
    """At-risk and event indicators for each step from 1, both 0 or 1 of shape (trials, steps).

    Args:
        last: The step of the event, or the last step without it, shape (trials,).
        happened: Whether the event happened at that step, of the same shape.
    """
    step = np.arange(1, int(last.max(initial=0)) + 1)
    event = (last[:, None] == step) & happened[:, None]
    return (last[:, None] >= step).astype(np.float64), event.astype(np.float64)


def excess(x: Array, event: Array, running: Array, *, cluster: NDArray[np.int64]) -> Excess:
    """Excess of events with a feature, given the trials at risk at each step.

    Args:
        x: The feature, shape (columns, trials).
        event: Event indicator, 0 or 1, shape (trials, steps).
        running: At-risk indicator, 0 or 1, shape (trials, steps).
        cluster: Cluster from 0, shape (trials,).
    """
    n = running.sum(axis=0)
    some = np.maximum(n, 1.0)
    score = running * (x[..., None] - (x @ running / some)[:, None]) * (event - event.sum(axis=0) / some)
    unbiased = np.sqrt(n / np.maximum(n - 1, 1.0))
    sums = np.zeros((int(cluster.max(initial=-1)) + 1, len(score)))
    np.add.at(sums, cluster, np.sum(score * unbiased, axis=2).T)
    sums = np.round(sums, 10)  # rounding noise is not evidence
    return Excess(total=score.sum(axis=(1, 2)), covariance=sums.T @ sums, clusters=len(sums))
