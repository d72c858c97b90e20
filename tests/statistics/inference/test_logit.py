"""Logistic regressions over doses: statsmodels' fit where that is right, the maximum of the likelihood everywhere."""

import warnings

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from statsmodels.genmod.families import Binomial
from statsmodels.genmod.generalized_linear_model import GLM

from lockprobe.statistics.inference.logit import Counts, logit_fit


@st.composite
def counted(draw):
    """Counts at two to seven flip rates."""
    dose = draw(st.lists(st.integers(0, 20), min_size=2, max_size=7, unique=True).map(sorted))
    solved, failed = (draw(st.lists(st.integers(0, 30), min_size=len(dose), max_size=len(dose))) for _ in range(2))
    assume(all(a + b for a, b in zip(solved, failed, strict=True)))
    return of(np.array(dose) / 20, solved, np.add(solved, failed))


def of(dose, solved, n):
    return Counts(dose=np.array(dose), solved=np.array(solved, dtype=float), n=np.array(n, dtype=float))


def polynomial(counts, order):
    return np.vander(counts.dose, order + 1, increasing=True)


def by_statsmodels(design, counts, **settings):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it takes an exact fit for separation
        outcomes = np.column_stack([counts.solved, counts.n - counts.solved])
        return GLM(outcomes, design, family=Binomial()).fit(maxiter=200, **settings)


def standard_scores(design, counts, coefficients, covariance):
    """The slopes of the likelihood, in standard errors of the coefficients; 0 at its maximum."""
    logit = design @ coefficients
    slope = design.T @ (counts.solved - counts.n / (1 + np.exp(-np.clip(logit, -700, 700))))
    return slope * np.sqrt(np.diag(covariance))


@given(counted(), st.integers(0, 3))
def test_a_fit_is_that_of_statsmodels(counts, order):
    """A second fit of statsmodels starts at its first: its covariance is that of the last step but one."""
    design = polynomial(counts, min(order, len(counts.dose) - 1))
    fit = logit_fit(design, counts)
    assume(fit is not None)
    library = by_statsmodels(design, counts, tol=1e-13)
    library = by_statsmodels(design, counts, start_params=library.params, tol=1e-13)
    error = library.bse
    assume(np.all(error < 1e6))  # beyond, chances near 0 and 1 are clipped by statsmodels
    assert fit.coefficients / error == pytest.approx(library.params / error, abs=1e-8)
    pairs = np.outer(error, error)
    assert fit.covariance / pairs == pytest.approx(library.cov_params() / pairs, abs=1e-8)
    assert (fit.log_likelihood, fit.deviance) == pytest.approx((library.llf, max(0, library.deviance)), abs=1e-8)


def test_the_error_of_one_share_is_exact_where_that_of_statsmodels_is_only_near():
    counts = of([0.0], [3], [16])
    exact = 1 / (16 * 3 / 16 * 13 / 16)
    assert logit_fit(polynomial(counts, 0), counts).covariance[0, 0] == pytest.approx(exact, rel=1e-14)
    assert by_statsmodels(polynomial(counts, 0), counts).cov_params()[0, 0] != pytest.approx(exact, rel=1e-8)


def test_doses_far_apart_are_fitted_where_statsmodels_fails():
    far = of([0.5, 0.8, 1.4, 3.2, 4.6, 6.3, 4700.0], [5, 0, 7, 15, 2, 8, 0], [25, 11, 38, 21, 9, 39, 7])
    design = polynomial(far, 3)
    fit, library = logit_fit(design, far), by_statsmodels(design, far)
    assert np.abs(standard_scores(design, far, fit.coefficients, fit.covariance)).max() < 1e-4
    assert np.abs(standard_scores(design, far, library.params, fit.covariance)).max() > 0.1
    assert fit.log_likelihood > library.llf


def test_a_fit_of_doses_far_apart_warns_of_nothing():
    far = of([0.0, 1.0, 2.0, 1000.0], [2, 7, 6, 0], [8, 8, 8, 8])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fit = logit_fit(polynomial(far, 2), far)
    assert fit is not None
    assert np.isfinite([fit.log_likelihood, fit.deviance]).all()
    assert polynomial(far, 2)[:3] @ fit.coefficients == pytest.approx(np.log([2 / 6, 7 / 1, 6 / 2]), abs=1e-6)


@pytest.mark.parametrize("unit", [1.0, 1e4])
def test_separated_trials_have_no_fit_whatever_the_unit(unit):
    """A logit may rise without end between 0.2 and 0.4; a trial that stands against it holds it."""
    doses = np.array([0.0, 0.2, 0.4, 0.6]) * unit
    apart = of(doses, [0, 0, 8, 8], [8, 8, 8, 8])
    assert logit_fit(polynomial(apart, 1), apart) is None
    held = of(doses, [0, 1, 8, 8], [8, 8, 8, 8])
    assert logit_fit(polynomial(held, 1), held) is None
    crossed = of(doses, [0, 1, 7, 8], [8, 8, 8, 8])
    assert logit_fit(polynomial(crossed, 1), crossed).coefficients[1] > 0
