"""Observed minus expected events by step, with a variance clustered by luck: the core of log-rank tests.

A log-rank test sums, over steps, how far the events with a feature exceed those expected if all trials at risk were
alike. Trials of equal repetition and trial share their luck over all p. So the differences are
summed per cluster, and their variance between clusters is the robust variance of Lin and Wei (1989), made unbiased
for few running trials.

Rejections at .05 under the null hypothesis, in 1500 studies of 7 p x 30 trials with luck shared over p by none and by
half of the trials: loop onset .047 and .045 with Student's t, .056 and .056 with chi-squared.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.distributions import student_tails
from lockprobe.statistics.proportions import ALPHA

Array = NDArray[np.float64]


class Excess(NamedTuple):
    """Observed minus expected events with a feature, their standard error between clusters of luck, and the P value.

    The P value is two-sided, of Student's t over clusters: 1 if all trials are alike, None with six clusters or fewer,
    where the statistic, which never exceeds their number, could never reject.
    """

    total: float
    error: float
    p_value: float | None

    @property
    def direction(self) -> int:
        """1 if there are more events with the feature than expected, -1 if fewer, else 0."""
        return int(np.sign(self.total))


def grid(last: NDArray[np.int64], happened: NDArray[np.bool_]) -> tuple[Array, Array]:
    """At-risk and event indicators for each step from 1, both 0 or 1 of shape (trials, steps)."""
    step = np.arange(1, int(last.max(initial=0)) + 1)
    event = (last[:, None] == step) & happened[:, None]
    return (last[:, None] >= step).astype(np.float64), event.astype(np.float64)


def excess(feature: Array, last: NDArray[np.int64], happened: NDArray[np.bool_], cluster: NDArray[np.int64]) -> Excess:
    """Excess of events with a feature, given the trials at risk at each step. Every column has the shape (trials,).

    Args:
        feature: The feature.
        last: The step of the event, or the last step without it.
        happened: Whether the event happened at that step.
        cluster: The cluster of luck, from 0.
    """
    running, event = grid(last, happened)
    n = running.sum(axis=0)
    some = np.maximum(n, 1.0)
    score = running * (feature[:, None] - feature @ running / some) * (event - event.sum(axis=0) / some)
    unbiased = np.sum(score * np.sqrt(n / np.maximum(n - 1, 1.0)), axis=1)
    sums = np.round(np.bincount(cluster, weights=unbiased), 10)  # rounding noise is not evidence
    total, error, clusters = float(score.sum()), float(np.sqrt(sums @ sums)), len(sums)
    if clusters < 2 or student_tails(clusters**0.5, clusters - 1) >= ALPHA:
        return Excess(total, error, None)
    return Excess(total, error, float(student_tails(total / error, clusters - 1)) if error else 1.0)
