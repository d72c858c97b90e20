"""The paper's trends over flip probability, with their limits (Figs. 4 and 5b).

The unit is one repetition of one condition: a :class:`Point`. The fits are least squares on shares, as in the paper.
An order of two is *not* evidence of a decline: of 2000 simulated studies in which success only levels off, AIC and
cross-validation both chose it in 53 %, with a maximum inside the range of p in 52 %.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.outcomes import Point

_GRID = 61
_EXACT = 1e-12
"""Mean squared residual below which a fit is exact."""

Array = NDArray[np.float64]

Quantity = Literal["success", "loop_rate"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Trend:
    """The second-order fit that the paper draws, with its band, and the orders that its criteria prefer.

    Attributes:
        orders: Criterion (``AIC``, ``cross-validation`` by leave-one-out error) -> order, 0 to 3, if it has a choice.
        dose: The doses at which the fit is evaluated.
        value: The fit there.
        low, high: 2.5th and 97.5th percentiles over bootstrap resamples; empty without resamples.
        turning: The dose of its extremum, if strictly inside the range.
        kind: ``maximum`` or ``minimum``; empty without one.
    """

    orders: Mapping[str, int]
    dose: tuple[float, ...]
    value: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    turning: float | None
    kind: str


def trend(points: Sequence[Point], quantity: Quantity, draws: Array) -> Trend | None:
    """Fit polynomials over doses as the paper does (Sec. 3.2); None with fewer than three doses.

    Args:
        points: Repetitions of conditions, each with at least one trial.
        quantity: The fitted quantity.
        draws: The quantity at those points in bootstrap resamples, shape (resamples, points).
    """
    x = np.array([point.dose for point in points], dtype=np.float64)
    y = np.array([getattr(point, quantity) for point in points], dtype=np.float64)
    doses = len(set(x.tolist()))
    if doses < 3:
        return None
    scores = [_scores(x, y, order) for order in range(min(3, doses - 1) + 1)]
    aic = list(enumerate(score[0] for score in scores))
    cv = [(order, score[1]) for order, score in enumerate(scores) if score[1] is not None]
    chosen = {"AIC": _chosen(aic), "cross-validation": _chosen(cv)}
    return Trend(orders={name: order for name, order in chosen.items() if order is not None}, **_quadratic(x, y, draws))


def _chosen(scores: Sequence[tuple[int, float | None]]) -> int | None:
    """The order with the smallest score; an exact fit (None) beats all, and the lower order wins a tie."""
    exact = [order for order, score in scores if score is None]
    if exact or not scores:
        return min(exact, default=None)
    best = min(score for _, score in scores if score is not None)
    return min(order for order, score in scores if score is not None and score <= best + 1e-9)


def _scores(x: Array, y: Array, order: int) -> tuple[float | None, float | None]:
    """Akaike's criterion under normal errors (None if the fit is exact), leave-one-out error (None of a lone point)."""
    design = np.vander(x, order + 1, increasing=True)
    pseudo = np.linalg.pinv(design)
    residuals = y - design @ (pseudo @ y)
    mean_square = float(np.mean(residuals**2))
    leverage = np.einsum("ij,ji->i", design, pseudo)
    aic = None if mean_square < _EXACT else len(y) * math.log(mean_square) + 2 * (order + 2)
    fixed = bool(np.any(leverage > 1 - 1e-9))
    return aic, None if fixed else math.sqrt(float(np.mean((residuals / (1 - leverage)) ** 2)))


def _quadratic(x: Array, y: Array, draws: Array) -> dict[str, Any]:
    first, last = float(x.min()), float(x.max())
    grid, fit = np.linspace(first, last, _GRID), np.linalg.pinv(np.vander(x, 3, increasing=True))
    basis, fitted = np.vander(grid, 3, increasing=True), fit @ y
    low, high = np.percentile(draws @ fit.T @ basis.T, [2.5, 97.5], axis=0) if len(draws) else ((), ())
    bend, edge = float(fitted[2]), 1e-9 * (last - first)  # inside the range by more than rounding
    where = -float(fitted[1]) / (2 * bend) if abs(bend) >= 1e-9 else math.nan
    inside = first + edge < where < last - edge
    return {
        "dose": tuple(grid.tolist()),
        "value": tuple((basis @ fitted).tolist()),
        "low": tuple(map(float, low)),
        "high": tuple(map(float, high)),
        "turning": where if inside else None,
        "kind": ("maximum" if bend < 0 else "minimum") if inside else "",
    }
