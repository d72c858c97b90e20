"""Logistic regression on counts, with a check for separation.

Trials at one p are one binomial count, which gives the same fit as single trials. Trials count as independent: luck
shared over p makes the true standard errors of differences smaller than these, not larger.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.distributions import log_binomial

Array = NDArray[np.float64]

_STEPS = 200
"""Most steps to the maximum. Four to eight are usual; each unit of logit far out takes one."""

_SETTLED = 1e-9
"""A step of this size, relative to the logits, leaves an error of about its square."""

_NOISE = 1e-12
"""What a log-likelihood loses to rounding, relative to it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Counts:
    """Trials and successes per value of p, each of shape (values,), p rising.

    Attributes:
        dose: Flip probability, [0, 1].
        solved: Trials solved.
        n: Trials, at least 1.
    """

    dose: Array
    solved: Array
    n: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class LogitFit:
    """A maximum-likelihood fit of a binomial logit model.

    Attributes:
        coefficients: Shape (columns,).
        covariance: Inverse of the information, shape (columns, columns).
        log_likelihood: Log-likelihood of the counts, including binomial coefficients.
        deviance: Deviance from the saturated model, at least 0.
    """

    coefficients: Array
    covariance: Array
    log_likelihood: float
    deviance: float


def counts(p: NDArray[np.float64], solved: NDArray[np.bool_]) -> Counts:
    """Count trials and successes per value of p; both columns have the shape (trials,)."""
    values = np.unique(np.asarray(p, dtype=np.float64))
    here = values[:, None] == p
    return Counts(
        dose=values, solved=(here & solved).sum(axis=1, dtype=np.float64), n=here.sum(axis=1, dtype=np.float64)
    )


def logit_fit(design: Array, counted: Counts) -> LogitFit | None:
    """Fit a logistic regression; None if a combination of the columns separates solved from unsolved trials.

    Args:
        design: Shape (values, columns), of full column rank.
        counted: As many values as the design has rows.
    """
    basis, scale = np.linalg.qr(design)  # orthonormal columns: the scale of a design's columns costs no digits
    if _separated(basis, counted):
        return None
    from scipy.special import xlogy

    best, failed = _maximum(basis, counted), counted.n - counted.solved
    root = np.linalg.solve(scale, _root_covariance(basis @ best, basis, counted))
    least = -xlogy(counted.solved, counted.solved / counted.n) - xlogy(failed, failed / counted.n)
    deviance = max(0.0, 2 * float(np.sum(_losses(basis @ best, counted) - least)))
    saturated = float(np.sum(log_binomial(counted.solved, counted.n, counted.solved / counted.n)))
    return LogitFit(
        coefficients=np.linalg.solve(scale, best),
        covariance=root @ root.T,
        log_likelihood=saturated - deviance / 2,
        deviance=deviance,
    )


def _maximum(basis: Array, counted: Counts) -> Array:
    """The coefficients of the highest likelihood, shape (columns,), by Newton's method.

    The likelihood is concave. A step that would lower it is halved.
    """
    found, failed = np.zeros(basis.shape[1]), counted.n - counted.solved
    for _ in range(_STEPS):
        logit = basis @ found
        slope = basis.T @ (counted.solved * _chance(-logit) - failed * _chance(logit))
        root = _root_covariance(logit, basis, counted)
        step, here = root @ (root.T @ slope), np.sum(_losses(logit, counted))
        while np.sum(_losses(basis @ (found + step), counted)) > here + _NOISE * (1 + here):
            step = step / 2
        found = found + step
        if np.all(np.abs(basis @ step) <= _SETTLED * (1 + np.abs(logit))):
            break
    return found


def _root_covariance(logit: Array, basis: Array, counted: Counts) -> Array:
    """A matrix of shape (columns, values); its product with its transpose is the inverse of the information."""
    weight = counted.n * _chance(logit) * _chance(-logit)
    return np.asarray(np.linalg.pinv(np.sqrt(weight)[:, None] * basis), dtype=np.float64)


def _chance(logit: Array) -> Array:
    return np.exp(-np.logaddexp(0, -logit))


def _losses(logit: Array, counted: Counts) -> Array:
    """Each value's negative log-likelihood without its binomial coefficient."""
    failed = counted.n - counted.solved
    return counted.solved * np.logaddexp(0, -logit) + failed * np.logaddexp(0, logit)


def _separated(basis: Array, counted: Counts) -> bool:
    """Whether the likelihood has no finite maximum (Albert & Anderson 1984).

    That is so if a combination of columns, not zero everywhere, is >= 0 wherever a trial was solved and <= 0 wherever
    one was not. The columns are orthonormal.
    """
    all_solved, none_solved = counted.solved == counted.n, counted.solved == 0
    mixed = ~all_solved & ~none_solved
    if np.linalg.matrix_rank(basis[mixed]) == basis.shape[1]:
        return False
    from scipy.optimize import linprog

    signed = np.vstack([basis[all_solved], -basis[none_solved]])
    found = linprog(
        -signed.sum(axis=0),
        A_ub=-signed,
        b_ub=np.zeros(len(signed)),
        A_eq=basis[mixed] if mixed.any() else None,
        b_eq=np.zeros(mixed.sum()) if mixed.any() else None,
        bounds=(-1, 1),
    )
    return float(found.fun or 0.0) < -1e-6  # zero columns always qualify, so there is an optimum
