"""Logistic regression on counts, with a check for separation.

Trials at one p are one binomial count, which gives the same fit as single trials. Trials count as independent: luck
shared over p makes the true standard errors of differences smaller than these, not larger.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Counts", "LogitFit", "counts", "logit_fit"]

Array = NDArray[np.float64]


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
        deviance: Deviance from the saturated model.
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
    if _separated(design, counted):
        return None
    from statsmodels.genmod.families import Binomial
    from statsmodels.genmod.generalized_linear_model import GLM

    with warnings.catch_warnings():
        # As many columns as counts fit exactly, which statsmodels takes for separation. Of doses far apart it computes
        # exp(large) on the way to a chance of 1.
        warnings.simplefilter("ignore")
        fit = GLM(np.column_stack([counted.solved, counted.n - counted.solved]), design, family=Binomial()).fit()
        return LogitFit(
            coefficients=fit.params,
            covariance=fit.cov_params(),
            log_likelihood=float(fit.llf),
            deviance=max(0.0, float(fit.deviance)),
        )


def _separated(design: Array, counted: Counts) -> bool:
    """Whether the likelihood has no finite maximum (Albert & Anderson 1984).

    That is so if a combination of columns, not zero everywhere, is >= 0 wherever a trial was solved and <= 0 wherever
    one was not.
    """
    all_solved, none_solved = counted.solved == counted.n, counted.solved == 0
    mixed = ~all_solved & ~none_solved
    if np.linalg.matrix_rank(design[mixed]) == design.shape[1]:
        return False
    from scipy.optimize import linprog

    basis = np.linalg.qr(design)[0]
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
