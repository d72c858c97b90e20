"""Binomial polynomials agree with a likelihood maximised by other means, and exist only where they should."""

import itertools

import numpy as np
import pytest
from scipy.optimize import linprog, minimize
from scipy.stats import binom, chi2

from lockprobe.report.prose.hypothesis_tests import why_missing
from lockprobe.statistics.inference.logit import counts, logit_fit
from lockprobe.statistics.inference.shape import binomial_orders

EXPECTED = (7, 12, 16, 19, 20, 18, 15)
"""Of 30 at p = 0 to 0.6, rounded from the paper's 23 %, 67 % and about 50 %."""


def trials(solved, n=30, p=None):
    p = np.arange(len(solved)) / 10 if p is None else np.asarray(p)
    return np.repeat(p, n), np.concatenate([np.arange(n) < k for k in solved])


def highest_likelihood(solved, order, n=30):
    p, k = np.arange(len(solved)) / 10, np.array(solved)

    def negative(coefficients):
        logit = np.polynomial.polynomial.polyval(p, coefficients)
        return -np.sum(binom.logpmf(k, n, 1 / (1 + np.exp(-np.clip(logit, -500, 500)))))

    return -minimize(negative, np.zeros(order + 1), method="BFGS", options={"gtol": 1e-6}).fun


def test_the_fits_maximise_the_likelihood():
    fitted = binomial_orders(*trials(EXPECTED))
    best = [highest_likelihood(EXPECTED, order) for order in range(4)]
    assert [order.log_likelihood for order in fitted.orders] == pytest.approx(best, abs=1e-4)
    for order, lower in zip(fitted.orders[1:], best, strict=False):
        assert order.p_value == pytest.approx(chi2.sf(2 * (best[order.order] - lower), 1), rel=1e-2)
    assert fitted.orders[0].p_value is None
    saturated = sum(binom.logpmf(k, 30, k / 30) for k in EXPECTED)
    assert [order.deviance for order in fitted.orders] == pytest.approx([2 * (saturated - x) for x in best], abs=1e-3)


def test_the_expected_counts_of_the_paper():
    fitted = binomial_orders(*trials(EXPECTED))
    assert (fitted.n, fitted.order, fitted.note) == (210, 2, "")
    assert round(fitted.orders[2].p_value, 4) == 0.0024


@pytest.mark.parametrize(
    ("solved", "orders", "note"),
    [
        ((0,) * 7, 0, "no trial was solved"),
        ((30,) * 7, 0, "every trial was solved"),
        ((0, 0, 0, 30, 30), 1, "order 1 separates"),
        ((0, 0, 15, 30, 30), 1, "order 1 separates"),
        ((0, 30, 30, 0), 2, "order 2 separates"),
        ((0, 0, 15, 30, 30, 20, 10), 3, "order 3 separates"),
    ],
)
def test_what_has_no_maximum_is_not_fitted(solved, orders, note):
    fitted = binomial_orders(*trials(solved))
    assert len(fitted.orders) == orders
    assert (fitted.order, fitted.curve) == (None, None)
    assert note in why_missing(fitted.note)


def test_few_trials_or_values():
    assert binomial_orders(np.empty(0), np.empty(0, dtype=bool)).orders == ()
    assert why_missing(binomial_orders(np.zeros(2), np.array([True, False])).note) == "No fit: it needs three trials."
    assert [order.order for order in binomial_orders(*trials((7, 20))).orders] == [0, 1]
    assert [order.order for order in binomial_orders(*trials((7,))).orders] == [0]


def test_a_maximum_exists_exactly_if_no_polynomial_separates():
    """Patterns of none, some and all solved at four p (of mirror images one): against the strict definition."""
    for solved in itertools.product((0, 1, 2), repeat=4):
        if solved > solved[::-1]:
            continue
        p, wins = trials(solved, n=2)
        for order in range(4):
            design = np.vander(p, order + 1, increasing=True) * np.where(wins, 1, -1)[:, None]
            found = linprog(-design.sum(axis=0), A_ub=-design, b_ub=np.zeros(len(design)), bounds=(-1, 1)).fun
            counted = counts(p, wins)
            fit = logit_fit(np.vander(counted.dose, order + 1, increasing=True), counted)
            assert (fit is None) == (found < -1e-6), (solved, order)
