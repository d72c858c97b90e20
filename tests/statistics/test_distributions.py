"""Quantiles, tails, intervals and exact tests are those of ``scipy.stats``."""

import math
import subprocess
import sys
from statistics import NormalDist

import numpy as np
import pytest
from builders import write_study
from hypothesis import given
from hypothesis import strategies as st
from scipy import optimize, stats

from lockprobe.statistics import distributions
from lockprobe.statistics.proportions import wilson
from lockprobe.studies.options.studyfile import study

SHARES = st.floats(0.001, 0.999)
COUNTS = st.integers(0, 60)
SAMPLE = st.tuples(st.floats(-1, 1), st.floats(0.01, 2), st.integers(2, 40))


@given(SHARES, st.floats(1, 500), st.floats(-30, 30))
def test_students_distribution(share, freedom, value):
    assert distributions.student_quantile(share, freedom) == pytest.approx(stats.t.ppf(share, freedom), rel=1e-11)
    assert distributions.student_tails(value, freedom) == pytest.approx(2 * stats.t.sf(abs(value), freedom), rel=1e-11)


@given(st.integers(0, 400), st.integers(0, 400))
def test_the_sign_test(first, second):
    expected = stats.binomtest(first, first + second).pvalue if first + second else 1.0
    assert distributions.sign_test(first, second) == pytest.approx(expected, rel=1e-10)


@given(SAMPLE, SAMPLE)
def test_welchs_test(first, second):
    expected = stats.ttest_ind_from_stats(*first, *second, equal_var=False).pvalue
    assert distributions.welch_test(first, second) == pytest.approx(expected, rel=1e-9)
    assert distributions.welch_test((0.1, 0.0, 5), (0.2, 0.0, 5)) is None  # without spread nothing is known


@given(st.tuples(COUNTS, COUNTS, COUNTS, COUNTS) | st.just((40_000, 60_000, 39_000, 61_000)))
def test_fishers_exact_test(counts):
    table = np.reshape(counts, (2, 2))
    assert distributions.fisher_exact(table) == pytest.approx(stats.fisher_exact(table).pvalue, rel=1e-6)


@given(st.floats(-5, 5), st.floats(0.01, 5), st.floats(0.001, 40))
def test_a_root_is_that_of_brentq(at, width, steep):
    """Of curves that are flat on one side and steep on the other, where regula falsi alone would creep."""
    of = lambda x: math.expm1(steep * (x - at))  # noqa: E731
    found = distributions.root(of, at - width, at + 2 * width)
    assert found == pytest.approx(optimize.brentq(of, at - width, at + 2 * width, xtol=1e-14), abs=1e-10)
    assert distributions.root(of, at, at + 1) == at


@given(st.integers(1, 500), st.floats(0, 1), st.floats(0.5, 0.999))
def test_wilsons_interval_is_that_of_scipy(n, share, level):
    count = round(share * n)
    library = stats.binomtest(count, n).proportion_ci(level, method="wilson")
    found = wilson(count / n, n, NormalDist().inv_cdf((1 + level) / 2))
    assert found == pytest.approx((library.low, library.high), abs=1e-12)


def test_the_numbers_of_a_study_are_there_without_scipy(tmp_path) -> None:
    asked = {"agent": ["cognitive:perseverant", "random"], "p": [0, 0.4], "trials": 8, "repetitions": 1}
    directory = write_study(tmp_path / "study", study("flips", **asked, boxes=2))
    code = (
        f"import sys, lockprobe; found = lockprobe.results({str(directory)!r}); assert found.answer;"
        "assert not {name for name in sys.modules if name.startswith('scipy')}"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
