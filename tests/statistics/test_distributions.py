"""Quantiles, tails and exact tests are those of ``scipy.stats``."""

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from lockprobe.statistics import distributions

SHARES = st.floats(0.001, 0.999)
FREEDOM = st.integers(1, 500)
COUNTS = st.integers(0, 60)


@given(SHARES, FREEDOM, st.floats(-30, 30))
def test_students_distribution(share: float, freedom: int, value: float) -> None:
    assert distributions.student_quantile(share, freedom) == pytest.approx(stats.t.ppf(share, freedom), rel=1e-12)
    assert distributions.student_tails(value, freedom) == pytest.approx(2 * stats.t.sf(abs(value), freedom), rel=1e-12)


def test_student_tails_of_an_array() -> None:
    found = distributions.student_tails(np.array([-1.0, 0.0, 2.0]), 5)
    np.testing.assert_allclose(found, 2 * stats.t.sf([1.0, 0.0, 2.0], 5))


SAMPLE = st.tuples(st.floats(-1, 1), st.floats(0.01, 2), st.integers(2, 40))


@given(SAMPLE, SAMPLE)
def test_welchs_test(first: tuple[float, float, int], second: tuple[float, float, int]) -> None:
    expected = stats.ttest_ind_from_stats(*first, *second, equal_var=False).pvalue
    assert distributions.welch_test(first, second) == pytest.approx(expected, rel=1e-9)


def test_welchs_test_of_samples_without_spread_is_not_known() -> None:
    assert distributions.welch_test((0.1, 0.0, 5), (0.2, 0.0, 5)) is None


@given(SHARES)
def test_normal(share: float) -> None:
    assert distributions.normal_quantile(share) == pytest.approx(stats.norm.ppf(share), rel=1e-12, abs=1e-15)


@given(COUNTS, COUNTS, SHARES)
def test_binomial(count: int, more: int, share: float) -> None:
    n = count + more
    assert distributions.sign_test(count, more) == pytest.approx(stats.binomtest(count, n).pvalue if n else 1.0)
    if n:
        expected = stats.binomtest(count, n).proportion_ci(share, method="exact")
        assert distributions.binomial_interval(count, n, share) == pytest.approx(tuple(expected), abs=1e-9)


@given(COUNTS, COUNTS, COUNTS, COUNTS)
def test_fishers_exact_test(a: int, b: int, c: int, d: int) -> None:
    table = [[a, b], [c, d]]
    assert distributions.fisher_exact(table) == pytest.approx(stats.fisher_exact(table).pvalue, rel=1e-9)


def test_large_tables() -> None:
    table = [[40_000, 60_000], [39_000, 61_000]]
    assert distributions.fisher_exact(table) == pytest.approx(stats.fisher_exact(table).pvalue, rel=1e-6)


def test_what_a_report_needs_imports_neither_scipy_stats_nor_an_optimizer() -> None:
    code = (
        "import sys; from lockprobe.statistics import proportions as p; one, two = p.proportion(3, 9), p.proportion(7, 9);"
        "p.difference(one, two); p.proportion(3, 9, method='exact');"
        "from lockprobe.statistics.loops import cover; cover('ABCDABCDABCDABCDABCD');"
        "assert not {'scipy.stats', 'scipy.optimize'} & {*sys.modules}"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
