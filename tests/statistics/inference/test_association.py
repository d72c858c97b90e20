"""The correlation of loops and success is the library's, with an interval where there are resamples."""

import numpy as np
import pytest
from scipy import stats

from lockprobe.statistics.inference.association import correlation


def test_r_and_its_p_value_are_the_librarys():
    rng = np.random.default_rng(1)
    x, y = rng.random((2, 21))
    draws = x + 0.1 * rng.normal(size=(500, 21)), y + 0.1 * rng.normal(size=(500, 21))
    r, low, high, p_value = correlation(x, y, draws)
    assert (r, p_value) == pytest.approx(tuple(stats.pearsonr(x, y)))
    resampled = [stats.pearsonr(*pair).statistic for pair in zip(*draws, strict=True)]
    assert (low, high) == pytest.approx(tuple(np.percentile(resampled, [2.5, 97.5])))
    assert correlation(x, y, (np.empty((0, 21)),) * 2)[1:3] == (None, None)
    assert correlation(x, -x, draws)[::3] == pytest.approx((-1, 0))


@pytest.mark.parametrize("y", [np.full(5, 0.5), np.arange(2.0), np.empty(0)])
def test_there_is_none_of_a_constant_or_of_fewer_than_three_points(y):
    assert correlation(np.arange(float(len(y))), y, (np.empty((0, len(y))),) * 2) is None
