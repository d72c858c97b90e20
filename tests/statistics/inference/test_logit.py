"""Logistic regressions over doses."""

import warnings

import numpy as np

from lockprobe.statistics.inference.logit import Counts, logit_fit


def test_a_fit_of_doses_far_apart_warns_of_nothing():
    far = Counts(dose=np.array([0.0, 1.0, 2.0, 1000.0]), solved=np.array([2.0, 7.0, 6.0, 0.0]), n=np.full(4, 8.0))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fit = logit_fit(np.vander(far.dose, 3, increasing=True), far)
    assert fit is not None
    assert np.isfinite([fit.log_likelihood, fit.deviance]).all()
