"""The paper's trends over flip probability, with their limits (Figs. 4 and 5b).

The unit is one repetition of one condition: a :class:`Point`. The fits are least squares on shares, as in the paper.
An order of two is *not* evidence of a decline: of 2000 simulated studies in which success only levels off, AIC and
cross-validation both chose it in 53 %, with a maximum inside the range of p in 52 %.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.outcomes import Point

_GRID = 61
_EXACT = 1e-12
"""Mean squared residual below which a fit is exact."""

Array = NDArray[np.float64]

Quantity = Literal["success", "loop_rate"]


@dataclass(frozen=True, slots=True, kw_only=True)
class OrderScore:
    """A least-squares polynomial of one order, with its scores.

    Attributes:
        order: 0 to 3.
        coefficients: From the constant upwards.
        aic: Akaike's criterion under normal errors; None where the fit is exact.
        cv_rmse: Leave-one-out root mean squared error; None if the fit has a single point.
    """

    order: int
    coefficients: tuple[float, ...]
    aic: float | None
    cv_rmse: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Quadratic:
    """The second-order fit that the paper draws, with its band.

    Attributes:
        coefficients: From the constant upwards.
        dose: The p at which the fit is evaluated.
        value: The fit there.
        low, high: 2.5th and 97.5th percentiles over bootstrap resamples; empty without resamples.
        turning: The p of the fit's extremum, if strictly inside the range of p.
        turning_kind: ``maximum`` or ``minimum``.
        turning_share: Share of resamples with an extremum of the same kind inside the range, [0, 1].
    """

    coefficients: tuple[float, ...]
    dose: tuple[float, ...]
    value: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    turning: float | None
    turning_kind: Literal["maximum", "minimum"] | None
    turning_share: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class TrendFit:
    """The trend of one quantity over p, as the paper fits it.

    Attributes:
        n: Points.
        orders: The polynomials that the values of p allow, orders 0 to 3.
        order_by_aic: The order that AIC prefers; None without a choice.
        order_by_cv: The order with the smallest leave-one-out error.
        quadratic: The second-order fit; None with fewer than three values of p.
        note: Why something is missing, as a short code; empty if nothing is.
    """

    n: int
    orders: tuple[OrderScore, ...] = ()
    order_by_aic: int | None = None
    order_by_cv: int | None = None
    quadratic: Quadratic | None = None
    note: str = ""


def trend_fit(points: Sequence[Point], quantity: Quantity, draws: Array) -> TrendFit:
    """Fit polynomials over p as the paper does (Sec. 3.2).

    Args:
        points: Repetitions of conditions, each with at least one trial.
        quantity: The fitted quantity.
        draws: The quantity at those points in bootstrap resamples, shape (resamples, points).
    """
    x = np.array([point.dose for point in points], dtype=np.float64)
    y = np.array([getattr(point, quantity) for point in points], dtype=np.float64)
    values = len(set(x.tolist()))
    if values < 3:
        return TrendFit(n=len(points), note=f"no fit with {values} doses")
    orders = tuple(_score(x, y, order) for order in range(min(3, values - 1) + 1))
    return TrendFit(
        n=len(points),
        orders=orders,
        order_by_aic=_chosen([(score.order, score.aic) for score in orders]),
        order_by_cv=_chosen([(score.order, score.cv_rmse) for score in orders if score.cv_rmse is not None]),
        quadratic=_quadratic(x, draws, orders[2].coefficients),
        note="" if len(draws) else "no band",
    )


def _chosen(scores: Sequence[tuple[int, float | None]]) -> int | None:
    """The order with the smallest score; an exact fit (None) beats all, and the lower order wins a tie."""
    exact = [order for order, score in scores if score is None]
    if exact or not scores:
        return min(exact, default=None)
    best = min(score for _, score in scores if score is not None)
    return min(order for order, score in scores if score is not None and score <= best + 1e-9)


def _score(x: Array, y: Array, order: int) -> OrderScore:
    design = np.vander(x, order + 1, increasing=True)
    pseudo = np.linalg.pinv(design)
    coefficients = pseudo @ y
    residuals = y - design @ coefficients
    mean_square = float(np.mean(residuals**2))
    leverage = np.einsum("ij,ji->i", design, pseudo)
    fixed = bool(np.any(leverage > 1 - 1e-9))
    aic = None if mean_square < _EXACT else len(y) * math.log(mean_square) + 2 * (order + 2)
    cv = None if fixed else math.sqrt(float(np.mean((residuals / (1 - leverage)) ** 2)))
    return OrderScore(order=order, coefficients=tuple(coefficients.tolist()), aic=aic, cv_rmse=cv)


def _turning(coefficients: Array, low: float, high: float) -> tuple[Array, NDArray[np.bool_]]:
    """The extrema of parabolas, and whether they lie inside the range, by more than rounding. A flat one has none."""
    bend, edge = coefficients[..., 2], 1e-9 * (high - low)
    flat = np.abs(bend) < 1e-9
    where = -coefficients[..., 1] / (2 * np.where(flat, 1.0, bend))
    return where, ~flat & (where > low + edge) & (where < high - edge)


def _quadratic(x: Array, draws: Array, coefficients: tuple[float, ...]) -> Quadratic:
    grid = np.linspace(x.min(), x.max(), _GRID)
    basis = np.vander(grid, 3, increasing=True)
    fitted = np.array(coefficients)
    where, inside = _turning(fitted, x.min(), x.max())
    resampled = draws @ np.linalg.pinv(np.vander(x, 3, increasing=True)).T
    low: Array = np.array([])
    high: Array = np.array([])
    share = None
    if len(resampled):
        low, high = np.percentile(resampled @ basis.T, [2.5, 97.5], axis=0)
        if inside:
            alike = np.sign(resampled[:, 2]) == np.sign(fitted[2])
            share = float(np.mean(alike & _turning(resampled, x.min(), x.max())[1]))
    return Quadratic(
        coefficients=coefficients,
        dose=tuple(grid.tolist()),
        value=tuple((basis @ fitted).tolist()),
        low=tuple(low.tolist()),
        high=tuple(high.tolist()),
        turning=float(where) if inside else None,
        turning_kind=("maximum" if fitted[2] < 0 else "minimum") if inside else None,
        turning_share=share,
    )
