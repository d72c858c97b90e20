"""Polynomial logistic regression of success on p, and the choice of its order.

The paper fits least squares to shares and lets AIC choose the order; here the trials are counted. An order of two is
*no* evidence of a decline: a success that rises from 23 % to 67 % and stays there is called quadratic in about half
of all studies with 30 trials at each of seven p (46 % by the likelihood ratio).
:mod:`~lockprobe.statistics.inference.ushape` tests for a decline.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.distributions import chi_squared_tail
from lockprobe.statistics.inference.logit import Counts, LogitFit, counts, logit_fit
from lockprobe.statistics.proportions import Z

_HIGHEST = 3
_GRID = 61


@dataclass(frozen=True, slots=True, kw_only=True)
class BinomialOrder:
    """A polynomial of one order in p on the logit scale, with its fit statistics.

    Attributes:
        order: 0 to 3.
        coefficients: From the constant upwards.
        log_likelihood: Log-likelihood of the counts per p, including binomial coefficients.
        aic: ``2 k - 2 log_likelihood`` with ``k = order + 1``.
        aicc: ``aic + 2 k (k + 1) / (n - k - 1)`` with n trials.
        deviance: Deviance from the saturated model.
        p_value: Likelihood-ratio test against the next lower order; None for order 0.
    """

    order: int
    coefficients: tuple[float, ...]
    log_likelihood: float
    aic: float
    aicc: float
    deviance: float
    p_value: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class BinomialCurve:
    """Success by p under one order.

    Attributes:
        dose: The p at which the curve is evaluated.
        value: Success there, [0, 1].
        low, high: Ends of the pointwise 95 % interval, from the normal interval on the logit scale.
    """

    dose: tuple[float, ...]
    value: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class BinomialOrders:
    """All polynomials that can be fitted, and the order that AICc prefers.

    Attributes:
        n: Trials.
        orders: From order 0 upwards, as far as the values of p allow and the likelihood has a maximum.
        order: The order with the smallest AICc; None if some order has no maximum, since it may be the better one.
        curve: Success by p under that order.
        note: Why something is missing, as a short code; empty if nothing is.
    """

    n: int
    orders: tuple[BinomialOrder, ...]
    order: int | None
    curve: BinomialCurve | None
    note: str


def binomial_orders(p: NDArray[np.float64], solved: NDArray[np.bool_]) -> BinomialOrders:
    """Fit polynomials of order 0 to 3, as far as the values of p allow; p and solved have the shape (trials,)."""
    counted = counts(p, solved)
    n = int(counted.n.sum())
    allowed = range(min(_HIGHEST, len(counted.dose) - 1, n - 3) + 1)
    found = []
    for order in allowed:
        if (fit := logit_fit(np.vander(counted.dose, order + 1, increasing=True), counted)) is None:
            break
        found.append(fit)
    orders = tuple(_order(n, found, order) for order in range(len(found)))
    if not allowed or len(found) < len(allowed):
        return BinomialOrders(n=n, orders=orders, order=None, curve=None, note=_why_not_fitted(counted, len(found)))
    best = min(orders, key=lambda order: order.aicc).order
    return BinomialOrders(n=n, orders=orders, order=best, curve=_curve(counted, found[best]), note="")


def _why_not_fitted(counted: Counts, order: int) -> str:
    if counted.n.sum() < 3:
        return "fewer than three trials"
    if counted.solved.sum() in {0, counted.n.sum()}:
        return "every trial solved" if counted.solved.sum() else "no trial solved"
    return f"order {order} separates"


def _order(n: int, fits: list[LogitFit], order: int) -> BinomialOrder:
    fit, k = fits[order], order + 1
    gain = 2 * (fit.log_likelihood - fits[order - 1].log_likelihood) if order else None
    aic = 2 * k - 2 * fit.log_likelihood
    return BinomialOrder(
        order=order,
        coefficients=tuple(fit.coefficients.tolist()),
        log_likelihood=fit.log_likelihood,
        aic=aic,
        aicc=aic + 2 * k * (k + 1) / (n - k - 1),
        deviance=fit.deviance,
        p_value=None if gain is None else chi_squared_tail(max(0.0, gain), 1),
    )


def _curve(counted: Counts, fit: LogitFit) -> BinomialCurve:
    from scipy.special import expit

    grid = np.linspace(counted.dose[0], counted.dose[-1], _GRID)
    basis = np.vander(grid, len(fit.coefficients), increasing=True)
    middle = basis @ fit.coefficients
    spread = Z * np.sqrt(np.einsum("ij,jk,ik->i", basis, fit.covariance, basis))
    return BinomialCurve(
        dose=tuple(grid.tolist()),
        value=tuple(expit(middle).tolist()),
        low=tuple(expit(middle - spread).tolist()),
        high=tuple(expit(middle + spread).tolist()),
    )
