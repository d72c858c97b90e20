"""Intervals and tests of proportions: published numbers, symmetry, coverage."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom, binomtest
from statsmodels.stats.proportion import confint_proportions_2indep

from lockprobe.statistics.proportions import difference, proportion, ratio, wilson

BASE, BEST = proportion(7, 30), proportion(20, 30)


@given(st.integers(1, 500), st.floats(0, 1), st.floats(0.5, 0.999))
def test_wilsons_interval_is_that_of_scipy(n, share, level):
    count = round(share * n)
    found, library = proportion(count, n, level), binomtest(count, n).proportion_ci(level, method="wilson")
    assert (found.low, found.high) == pytest.approx((library.low, library.high), abs=1e-12)


@given(st.floats(0, 1), st.just(0.0) | st.floats(1e-3, 1e6), st.floats(0.1, 13))
def test_wilsons_interval_of_a_fraction_of_trials_holds_the_share_and_is_turned_with_it(share, n, z):
    low, high = wilson(share, n, z)
    assert 0 <= low <= share + 1e-12
    assert share - 1e-12 <= high <= 1
    assert wilson(1 - share, n, z) == pytest.approx((1 - high, 1 - low), abs=1e-9)
    if low > 0 and high < 1:  # its ends are z standard errors away, with the variance at the ends
        assert n * (share - low) ** 2 == pytest.approx(z**2 * low * (1 - low), rel=1e-4, abs=1e-12)
    if n == 0:
        assert (low, high) == (0.0, 1.0)
    assert wilson(share, 4 * n, z, design_effect=4) == (low, high)


def test_clopper_pearson_never_falls_below_its_level():
    counted = np.arange(13)
    intervals = [proportion(int(k), 12, method="exact") for k in counted]
    for truth in np.linspace(0, 1, 41):
        held = np.array([one.low <= truth <= one.high for one in intervals])
        assert binom.pmf(counted, 12, truth) @ held >= 0.95


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


def test_ratios_at_the_edge():
    assert ratio(proportion(0, 30), BEST) is None
    nothing = ratio(BASE, proportion(0, 30))
    assert (nothing.value, nothing.low) == (0.0, 0.0)
    assert 0.4 < nothing.high < 0.6
    full = ratio(proportion(30, 30), proportion(30, 30))
    assert (full.low, full.high) == pytest.approx((0.8848, 1.1302), abs=1e-4)
