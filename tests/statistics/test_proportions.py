"""Intervals and tests of proportions: published numbers, symmetry, coverage."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binomtest
from statsmodels.stats.proportion import confint_proportions_2indep

from lockprobe.statistics.proportions import difference, proportion, ratio

BASE, BEST = proportion(7, 30), proportion(20, 30)


@given(st.integers(1, 500), st.floats(0, 1), st.floats(0.5, 0.999))
def test_wilsons_interval_is_that_of_scipy(n, share, level):
    count = round(share * n)
    found, library = proportion(count, n, level), binomtest(count, n).proportion_ci(level, method="wilson")
    assert (found.low, found.high) == pytest.approx((library.low, library.high), abs=1e-12)


def test_the_peak_of_the_paper_against_its_baseline():
    away = difference(BASE, BEST)
    assert [round(value, 3) for value in (away.value, away.low, away.high)] == [0.433, 0.182, 0.616]
    assert [round(value, 2) for value in ratio(BASE, BEST)] == [2.86, 1.50, 5.90]


@pytest.mark.parametrize("solved", [0, 9])
def test_nothing_differs_or_nothing_is_there(solved):
    assert difference(proportion(solved, 9), proportion(solved, 9)).p_value == 1.0
    assert difference(proportion(0, 0), BEST) is None
    assert ratio(proportion(0, 0), BEST) is None


def test_the_score_interval_is_that_of_statsmodels_where_that_is_right():
    """Where every trial of a sample is solved, statsmodels 0.15 gives the estimate itself as a limit."""
    for a, b in ((7, 20), (20, 7), (1, 1), (5, 28), (3, 0)):
        found = ratio(proportion(a, 30), proportion(b, 30))
        low, high = confint_proportions_2indep(b, 30, a, 30, compare="ratio", method="score")
        assert (found.low, found.high) == pytest.approx((low, high), abs=1e-5)
