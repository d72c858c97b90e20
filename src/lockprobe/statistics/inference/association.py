"""The paper's correlation of looping and success (Fig. 5a)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.distributions import student_tails

Array = NDArray[np.float64]

_CONSTANT = 1e-12
"""Sum of squares below which a quantity is constant."""


def correlation(
    x: Array, y: Array, drawn: tuple[Array, Array]
) -> tuple[float, float | None, float | None, float] | None:
    """Pearson's r over points, the ends of its 95 % interval, and its P value; None of a constant or of two points.

    The ends are percentiles over resamples, None without any. The P value is from Student's t, as if points were
    independent and trials of equal length.

    Args:
        x: Shape (points,).
        y: Of the same shape.
        drawn: Both in bootstrap resamples, shape (resamples, points).
    """
    r = float(_pearson(x[None], y[None])[0]) if len(x) >= 3 else math.nan
    if not math.isfinite(r):
        return None
    free = len(x) - 2
    p_value = student_tails(r * math.sqrt(free / (1 - r * r)), free) if abs(r) < 1 else 0.0
    draws = _pearson(*drawn)
    finite = draws[np.isfinite(draws)]
    low, high = np.percentile(finite, [2.5, 97.5]).tolist() if len(finite) else (None, None)
    return r, low, high, float(p_value)


def _pearson(x: Array, y: Array) -> Array:
    """Correlations over the points of (samples, points); NaN if either is constant."""
    x, y = (one - one.mean(axis=1, keepdims=True) for one in (x, y))
    squares = np.sum(x**2, axis=1), np.sum(y**2, axis=1)
    constant = np.minimum(*squares) < _CONSTANT
    scale = np.where(constant, 1.0, np.sqrt(squares[0] * squares[1]))
    return np.where(constant, math.nan, np.clip(np.sum(x * y, axis=1) / scale, -1.0, 1.0))
