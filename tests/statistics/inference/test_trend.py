"""Fits recover what was put in, say so when there is nothing to fit, and depend on their seed alone."""

import numpy as np
import pytest

from lockprobe.report.prose.hypothesis_tests import why_missing
from lockprobe.statistics.inference.trend import trend_fit
from lockprobe.statistics.outcomes import Point

P7 = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)


NONE = np.empty((0, 21))


def drawn(data, seed=1, spread=0.05):
    """Resamples as normal noise about the points."""
    return np.array([d.success for d in data]) + spread * np.random.default_rng(seed).normal(size=(500, len(data)))


def points(function, p=P7, repetitions=3, noise=0.0, seed=0):
    draw = np.random.default_rng(seed)
    return [
        Point(dose=x, repetition=r, n=10, success=function(x) + noise * draw.normal(), loop_rate=1 - function(x))
        for r in range(1, repetitions + 1)
        for x in p
    ]


def test_an_exact_parabola_is_found_with_its_peak():
    data = points(lambda x: 0.7 - 4 * (x - 0.4) ** 2)
    fit = trend_fit(data, "success", drawn(data))
    assert (fit.order_by_aic, fit.order_by_cv) == (2, 2)
    assert fit.quadratic.coefficients == pytest.approx((0.06, 3.2, -4.0))
    assert (fit.quadratic.turning, fit.quadratic.turning_kind) == (pytest.approx(0.4), "maximum")
    assert fit.quadratic.turning_share > 0.95
    loops = trend_fit(data, "loop_rate", 1 - drawn(data))
    assert (loops.quadratic.turning, loops.quadratic.turning_kind) == (pytest.approx(0.4), "minimum")


def test_leave_one_out_is_what_leaving_one_out_gives():
    data = points(lambda x: x, p=(0.0, 0.2, 0.5, 1.0), repetitions=1, noise=0.1)
    fit = trend_fit(data, "success", drawn(data))
    x, y = np.array([d.dose for d in data]), np.array([d.success for d in data])
    for score in fit.orders[:3]:
        errors = []
        for i in range(len(x)):
            keep = np.arange(len(x)) != i
            errors.append(y[i] - np.polyval(np.polyfit(x[keep], y[keep], score.order), x[i]))
        assert score.cv_rmse == pytest.approx(np.sqrt(np.mean(np.square(errors))))
    assert fit.orders[3].cv_rmse is None


def test_the_band_is_the_spread_of_fits_to_the_resamples():
    data = points(lambda x: 0.5 + x / 3, noise=0.1)
    draws = drawn(data)
    quadratic = trend_fit(data, "success", draws).quadratic
    x = np.array([d.dose for d in data])
    curves = [np.polyval(np.polyfit(x, row, 2), quadratic.dose) for row in draws]
    assert quadratic.low == pytest.approx(np.percentile(curves, 2.5, axis=0).tolist())
    assert quadratic.high == pytest.approx(np.percentile(curves, 97.5, axis=0).tolist())


def test_without_resamples_there_is_no_band():
    fit = trend_fit(points(lambda x: x), "success", NONE)
    assert fit.quadratic.low == ()
    assert "No band" in why_missing(fit.note)


@pytest.mark.parametrize("p", [(), (0.4,), (0.0, 0.4)])
def test_few_values_of_p_give_no_fit_and_say_so(p):
    data = points(lambda x: x, p=p)
    fit = trend_fit(data, "success", drawn(data))
    assert (fit.quadratic, fit.order_by_aic, fit.orders) == (None, None, ())
    assert "No fit" in why_missing(fit.note)
