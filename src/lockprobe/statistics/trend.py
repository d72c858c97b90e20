"""The paper's trends over flip probability, with their limits (Figs. 4 and 5b), its correlation, and their resamples.

The unit is one repetition of one condition: a :class:`Point`. The fits are least squares on shares, as in the paper.
That a parabola fits best is *not* evidence of a decline: of 2000 simulated studies in which success only levels off,
AIC and cross-validation both chose it in 53 %, with a maximum inside the range of p in 52 %. So no order is chosen.

Intervals are those of a cluster bootstrap: the trials of equal luck over all doses are a cluster, drawn within their
repetition, or all trials of one player.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.distributions import student_tails
from lockprobe.statistics.outcomes import Outcomes, Point

RESAMPLES = 2000

_AT_ONCE = 4_000_000
"""Numbers that are drawn at once, 32 MB."""

_CONSTANT = 1e-12
"""Sum of squares below which a quantity is constant."""

_GRID = 61
Array = NDArray[np.float64]

Quantity = Literal["success", "loop_rate"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Trend:
    """The second-order fit that the paper draws, with its band.

    Attributes:
        dose: The doses at which the fit is evaluated.
        value: The fit there.
        low, high: 2.5th and 97.5th percentiles over bootstrap resamples; empty without resamples.
        turning: The dose of its extremum, if strictly inside the range.
        kind: ``maximum`` or ``minimum``; empty without one.
    """

    dose: tuple[float, ...]
    value: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    turning: float | None
    kind: str


def trend(points: Sequence[Point], quantity: Quantity, draws: Array) -> Trend | None:
    """Fit a parabola over doses as the paper does (Sec. 3.2); None with fewer than three doses.

    ``draws`` are the quantity at the points in bootstrap resamples, shape (resamples, points).
    """
    x = np.array([point.dose for point in points], dtype=np.float64)
    y = np.array([getattr(point, quantity) for point in points], dtype=np.float64)
    if len(set(x.tolist())) < 3:
        return None
    first, last = float(x.min()), float(x.max())
    grid, fit = np.linspace(first, last, _GRID), np.linalg.pinv(np.vander(x, 3, increasing=True))
    basis, fitted = np.vander(grid, 3, increasing=True), fit @ y
    low, high = np.percentile(draws @ fit.T @ basis.T, [2.5, 97.5], axis=0) if len(draws) else ((), ())
    bend, edge = float(fitted[2]), 1e-9 * (last - first)  # inside the range by more than rounding
    where = -float(fitted[1]) / (2 * bend) if abs(bend) >= 1e-9 else math.nan
    inside = first + edge < where < last - edge
    return Trend(
        dose=tuple(grid.tolist()),
        value=tuple((basis @ fitted).tolist()),
        low=tuple(map(float, low)),
        high=tuple(map(float, high)),
        turning=where if inside else None,
        kind=("maximum" if bend < 0 else "minimum") if inside else "",
    )


FEWEST = 4
"""Points of which a correlation is given: of three, r is near -1 or 1 by chance, and its P value only rounding."""


def correlation(
    x: Array, y: Array, drawn: tuple[Array, Array]
) -> tuple[float, float | None, float | None, float] | None:
    """Pearson's r over points (Fig. 5a), the ends of its 95 % interval, its P value; None of a constant or few points.

    The ends are percentiles over resamples of both, shape (resamples, points), None without any. The P value is from
    Student's t, as if points were independent and trials of equal length.
    """
    r = float(_pearson(x[None], y[None])[0]) if len(x) >= FEWEST else math.nan
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


def resample(counted: Outcomes, rng: np.random.Generator, resamples: int = RESAMPLES) -> dict[Quantity, Array]:
    """Draw the clusters of one agent's trials with replacement, within every repetition; people from all.

    The shares of resampled points (:func:`lockprobe.statistics.outcomes.points`) have the shape (resamples, points), of
    zero rows if a repetition has a single cluster.

    Where nothing of a point was drawn, its observed share stands. Some resamples are drawn at a time, since how often
    each cluster is drawn would take gigabytes for all; the counts are whole numbers, so that no sum depends on it.
    """
    kinds, point = np.unique(np.column_stack([counted.dose, counted.repetition]), axis=0, return_inverse=True)
    cluster, repetition = counted.cluster, np.zeros_like(counted.repetition) if counted.crossed else counted.repetition
    strata = [np.unique(cluster[repetition == number]) for number in np.unique(repetition)]
    if any(len(members) < 2 for members in strata):
        return {"success": np.empty((0, len(kinds))), "loop_rate": np.empty((0, len(kinds)))}
    tables, drawn = np.zeros((3, int(cluster.max(initial=-1)) + 1, len(kinds))), np.zeros((3, resamples, len(kinds)))
    for table, event in zip(tables, (np.ones(len(counted)), counted.solved, counted.looped), strict=True):
        np.add.at(table, (cluster, point.reshape(-1)), event)
    for members in strata:
        own, even, rows = tables[:, members], np.full(len(members), 1 / len(members)), max(1, _AT_ONCE // len(members))
        for first in range(0, resamples, rows):
            size = min(rows, resamples - first)
            times = rng.multinomial(len(members), even, size=size).astype(np.float64)
            drawn[:, first : first + size] += times @ own
    (n, *happened), (all_, *observed) = drawn, tables.sum(axis=1)
    success, loop_rate = (
        np.where(n > 0, many / np.maximum(n, 1), total / all_) for many, total in zip(happened, observed, strict=True)
    )
    return {"success": success, "loop_rate": loop_rate}
