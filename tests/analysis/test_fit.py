"""Fits recover what was put in, say so when there is nothing to fit, and depend on their seed alone."""

import numpy as np
import pytest

from lockprobe.analysis.fit import LENGTH_CAVEAT, Point, correlation, trend_fit

P7 = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)


def rng(seed=1):
    return np.random.default_rng(seed)


def points(function, p=P7, repetitions=3, noise=0.0, seed=0):
    draw = np.random.default_rng(seed)
    return [
        Point(p=x, repetition=r, n=10, success=function(x) + noise * draw.normal(), loop_rate=1 - function(x))
        for r in range(1, repetitions + 1)
        for x in p
    ]


def test_an_exact_parabola_is_found_with_its_peak():
    fit = trend_fit(points(lambda x: 0.7 - 4 * (x - 0.4) ** 2), "success", rng())
    assert (fit.order_by_aic, fit.order_by_cv) == (2, 2)
    assert fit.quadratic.coefficients == pytest.approx((0.06, 3.2, -4.0))
    assert (fit.quadratic.turning, fit.quadratic.turning_kind) == (pytest.approx(0.4), "maximum")
    assert fit.quadratic.turning_share == 1.0
    loops = trend_fit(points(lambda x: 0.7 - 4 * (x - 0.4) ** 2), "loop_rate", rng())
    assert (loops.quadratic.turning, loops.quadratic.turning_kind) == (pytest.approx(0.4), "minimum")


@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_the_right_order_is_chosen_for_clear_data(order):
    shape = np.polynomial.Polynomial([0.4, 1.5, -6.0, 9.0][: order + 1])
    fit = trend_fit(points(lambda x: float(shape(x)), noise=0.002, repetitions=6, seed=3), "success", rng())
    assert (fit.order_by_aic, fit.order_by_cv) == (order, order)
    assert [score.order for score in fit.orders] == [0, 1, 2, 3]


def test_leave_one_out_is_what_leaving_one_out_gives():
    data = points(lambda x: x, p=(0.0, 0.2, 0.5, 1.0), repetitions=1, noise=0.1)
    fit = trend_fit(data, "success", rng())
    x, y = np.array([d.p for d in data]), np.array([d.success for d in data])
    for score in fit.orders[:3]:
        errors = []
        for i in range(len(x)):
            keep = np.arange(len(x)) != i
            errors.append(y[i] - np.polyval(np.polyfit(x[keep], y[keep], score.order), x[i]))
        assert score.cv_rmse == pytest.approx(np.sqrt(np.mean(np.square(errors))))
    assert fit.orders[3].cv_rmse is None


def test_band_holds_the_fit_and_depends_on_the_seed_alone():
    data = points(lambda x: 0.5 + x / 3, noise=0.1, repetitions=8)
    first, again, other = (trend_fit(data, "success", rng(seed)) for seed in (1, 1, 2))
    assert first == again
    assert first.quadratic.low != other.quadratic.low or first.quadratic.high != other.quadratic.high
    band = zip(first.quadratic.low, first.quadratic.value, first.quadratic.high, strict=True)
    assert all(low - 1e-9 <= value <= high + 1e-9 for low, value, high in band)


def test_one_repetition_has_no_band():
    fit = trend_fit(points(lambda x: x, repetitions=1), "success", rng())
    assert fit.quadratic.low == ()
    assert "No band" in fit.note


@pytest.mark.parametrize("p", [(), (0.4,), (0.0, 0.4)])
def test_few_values_of_p_give_no_fit_and_say_so(p):
    fit = trend_fit(points(lambda x: x, p=p), "success", rng())
    assert (fit.quadratic, fit.order_by_aic, fit.orders) == (None, None, ())
    assert "No fit" in fit.note


def test_nothing_solved_is_flat():
    fit = trend_fit(points(lambda x: 0.0), "success", rng())
    assert (fit.order_by_aic, fit.order_by_cv, fit.quadratic.turning) == (0, 0, None)
    assert set(np.abs(fit.quadratic.value) < 1e-9) == {True}


def test_r_of_a_straight_line():
    found = correlation(points(lambda x: x), rng())
    assert (found.r, found.n) == (pytest.approx(-1.0), 21)
    assert found.caveat == LENGTH_CAVEAT
    noisy = correlation(points(lambda x: 0.5 + x / 2, noise=0.2), rng())
    assert -1 <= noisy.low <= noisy.r <= noisy.high <= 1


def test_r_of_a_constant_is_none():
    assert correlation(points(lambda x: 0.5), rng()).r is None
    assert correlation(points(lambda x: x)[:2], rng()).r is None
    assert correlation([], rng()).n == 0
