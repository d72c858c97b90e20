"""One minus Kaplan-Meier: the plain share without censoring, the library's with it, intervals that hold."""

import numpy as np
import pytest
from scipy import stats

from lockprobe.statistics.loops.incidence import incidence
from lockprobe.statistics.proportions import proportion

DISTRIBUTIONS = {
    "few": 0.23 * np.clip((np.arange(21) - 3) / 17, 0, 1),
    "most": 0.67 * np.clip((np.arange(21) - 3) / 17, 0, 1),
    "fast": 0.95 * np.clip((np.arange(21) - 3) / 6, 0, 1),
    "rare": 0.02 * np.clip((np.arange(21) - 3) / 17, 0, 1),
}


def drawn(cumulative, n, rng, censored=20):
    """Steps and whether solved, for n trials of a cumulative distribution; censored at a step or at one each."""
    at = np.searchsorted(cumulative, rng.random(n), side="left")
    return np.minimum(at, censored), at <= censored


@pytest.mark.parametrize("n", [1, 3, 10, 30, 49, 97])
def test_without_early_censoring_it_is_the_plain_share_to_the_last_digit(n):
    for cumulative in DISTRIBUTIONS.values():
        steps, solved = drawn(cumulative, n, np.random.default_rng(n))
        found = incidence(steps, solved, 20)
        for step in range(21):
            plain = proportion(int(np.sum(solved & (steps <= step))), n)
            assert found.share[step] == plain.value
            assert (found.low[step], found.high[step]) == pytest.approx((plain.low, plain.high), abs=1e-9)


@pytest.mark.parametrize("seed", range(20))
def test_with_early_censoring_it_is_the_librarys(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 60))
    steps, solved = rng.integers(1, 21, n), rng.random(n) < 0.5
    found = incidence(steps, solved, 20)
    library = stats.ecdf(stats.CensoredData.right_censored(steps, ~solved)).cdf
    assert found.share == pytest.approx(library.evaluate(np.arange(21.0)).tolist(), abs=1e-12)
    low, share, high = map(np.array, (found.low, found.share, found.high))
    assert np.all((low >= 0) & (low <= share) & (share <= high) & (high <= 1))
    assert found.share == tuple(sorted(found.share))


def test_where_no_trial_is_left_running_nothing_bounds_the_share_from_above():
    found = incidence(np.array([5, 10]), np.array([True, False]), 20)
    assert found.share[10:] == (0.5,) * 11
    assert found.high[10] < 1
    assert found.high[11:] == (1.0,) * 10


def test_nothing_counted_means_nothing_known():
    found = incidence(np.zeros(0, dtype=int), np.zeros(0, dtype=bool), 3)
    assert np.isnan(found.share).all()
    assert (found.low, found.high) == ((0.0,) * 4, (1.0,) * 4)


def test_a_design_effect_widens_the_band_as_fewer_trials_would():
    steps, happened = np.repeat([5, 10, 20], 10), np.repeat([True, True, False], 10)
    alone, together = incidence(steps, happened, 20), incidence(steps, happened, 20, design_effect=2.0)
    fewer = incidence(steps[::2], happened[::2], 20)
    assert together.share == alone.share
    assert together.low == pytest.approx(fewer.low)
    assert together.high == pytest.approx(fewer.high)
