"""Intervals and tests of proportions: published numbers, symmetry, coverage."""

from statistics import NormalDist

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binomtest

from lockprobe.statistics.proportions import difference, proportion, wilson

BASE, BEST = proportion(7, 30), proportion(20, 30)


@given(st.integers(1, 500), st.floats(0, 1), st.floats(0.5, 0.999))
def test_wilsons_interval_is_that_of_scipy(n, share, level):
    count = round(share * n)
    library = binomtest(count, n).proportion_ci(level, method="wilson")
    found = wilson(count / n, n, NormalDist().inv_cdf((1 + level) / 2))
    assert found == pytest.approx((library.low, library.high), abs=1e-12)


def test_the_peak_of_the_paper_against_its_baseline():
    away = difference(BASE, BEST)
    assert [round(value, 3) for value in (away.value, away.low, away.high)] == [0.433, 0.182, 0.616]
