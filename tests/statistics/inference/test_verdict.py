"""The paper's rule for a peak (Sec. 3.2): both criteria choose order 2, and that fit has its maximum inside."""

from dataclasses import replace

import numpy as np
import pytest

from lockprobe.statistics.inference.shape import binomial_orders
from lockprobe.statistics.inference.trend import TrendFit, trend_fit
from lockprobe.statistics.inference.ushape import lind_mehlum, two_lines
from lockprobe.statistics.inference.verdict import shape_tests
from lockprobe.statistics.outcomes import Point

P7 = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
RULE = "order 2 by AIC and cross-validation, maximum inside"


def fitted(*coefficients: float, p: tuple[float, ...] = P7, noise: float = 0.004) -> TrendFit:
    """The fit to three repetitions of a polynomial over p, with a little noise."""
    draw, shape = np.random.default_rng(3), np.polynomial.Polynomial(coefficients)
    points = [
        Point(dose=x, repetition=r, n=10, success=float(shape(x)) + noise * draw.normal(), loop_rate=0.0)
        for r in (1, 2, 3)
        for x in p
    ]
    return trend_fit(points, "success", np.empty((0, len(points))))


def rule(fit: TrendFit) -> bool | None:
    """What the paper's rule says of a fit."""
    p, solved = np.repeat(P7, 2), np.tile([True, False], len(P7))
    tests = shape_tests(two_lines(p, solved), lind_mehlum(p, solved), binomial_orders(p, solved), fit)
    (found,) = (test.holds for test in tests if test.name == RULE)
    return found


@pytest.mark.parametrize(
    ("fit", "orders", "kind", "holds"),
    [
        (fitted(0.06, 3.2, -4.0), (2, 2), "maximum", True),
        (fitted(0.94, -3.2, 4.0), (2, 2), "minimum", False),
        (fitted(0.1, 1.5, -1.1), (2, 2), None, False),
        (fitted(0.1, 6.0, -20.0, 18.0), (3, 3), "maximum", False),
        (fitted(0.2, 1.0), (1, 1), None, False),
    ],
    ids=["peak", "valley", "rises throughout", "order three", "line"],
)
def test_the_papers_rule_needs_order_two_and_a_maximum_inside(fit, orders, kind, holds):
    assert ((fit.order_by_aic, fit.order_by_cv), fit.quadratic.turning_kind) == (orders, kind)
    assert rule(fit) is holds


@pytest.mark.parametrize("other", [1, 3])
def test_both_criteria_have_to_choose_order_two(other):
    peak = fitted(0.06, 3.2, -4.0)
    assert rule(replace(peak, order_by_aic=other)) is False
    assert rule(replace(peak, order_by_cv=other)) is False


def test_where_nothing_can_be_fitted_the_rule_says_nothing():
    assert rule(fitted(0.2, 1.0, p=(0.0, 0.4))) is None
