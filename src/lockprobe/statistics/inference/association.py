"""The paper's correlation of looping and success, with its limits (Fig. 5a)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.distributions import student_tails
from lockprobe.statistics.outcomes import Point

Array = NDArray[np.float64]

LENGTH_CAVEAT = (
    "Solved trials are shorter, and short trials hold fewer loops by chance alone: a strongly negative r is "
    "expected even if loops do no harm. It cannot tell cause from trial length."
)

_CONSTANT = 1e-12
"""Sum of squares below which a quantity is constant."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Correlation:
    """Pearson correlation of loop rate and success over points (paper, Fig. 5a).

    Attributes:
        r: [-1, 1]; None if either is constant or there are fewer than three points.
        n: Points.
        p_value: From Student's t for r, assuming independent points and trials of equal length; None without r.
        low, high: 2.5th and 97.5th percentiles over bootstrap resamples; None where nothing can be resampled.
        slope: Slope of the least-squares line of success on loop rate; None without r.
        intercept: Intercept of that line.
        caveat: Why r must not be read as an effect.
    """

    r: float | None
    n: int
    p_value: float | None = None
    low: float | None = None
    high: float | None = None
    slope: float | None = None
    intercept: float | None = None
    caveat: str = LENGTH_CAVEAT


def pearson(points: Sequence[Point]) -> Correlation:
    """Pearson's r of loop rate and success over points, without an interval."""
    pairs = np.array([[point.loop_rate, point.success] for point in points], dtype=np.float64).reshape(-1, 2)
    r = float(_pearson(pairs[None])[0]) if len(pairs) >= 3 else math.nan
    if not math.isfinite(r):
        return Correlation(r=None, n=len(points))
    free = len(pairs) - 2
    p_value = student_tails(r * math.sqrt(free / (1 - r * r)), free) if abs(r) < 1 else 0.0
    slope, intercept = np.polyfit(pairs[:, 0], pairs[:, 1], 1).tolist()
    return Correlation(r=r, n=len(points), p_value=p_value, slope=slope, intercept=intercept)


def correlation(points: Sequence[Point], loops: Array, success: Array) -> Correlation:
    """Pearson's r of loop rate and success over repetitions of conditions, as in Fig. 5a.

    Args:
        points: Each with at least one trial.
        loops: Loop rates at those points in bootstrap resamples, shape (resamples, points).
        success: Success at those points in the same resamples.
    """
    found = pearson(points)
    if found.r is None:
        return found
    draws = _pearson(np.stack([loops, success], axis=2))
    finite = draws[np.isfinite(draws)]
    if not len(finite):
        return found
    low, high = np.percentile(finite, [2.5, 97.5]).tolist()
    return replace(found, low=low, high=high)


def _pearson(pairs: Array) -> Array:
    """Correlations over the second axis of (samples, points, 2); NaN if a column is constant."""
    centred = pairs - pairs.mean(axis=1, keepdims=True)
    squares = np.sum(centred**2, axis=1)
    product = np.sum(centred[..., 0] * centred[..., 1], axis=1)
    scale = np.sqrt(squares[:, 0] * squares[:, 1])
    constant = np.any(squares < _CONSTANT, axis=1)
    return np.where(constant, math.nan, np.clip(product / np.where(constant, 1.0, scale), -1.0, 1.0))
