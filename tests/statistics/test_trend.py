"""The paper's fits, correlation and resamples: what was put in is recovered, and the band covers as it says."""

import numpy as np
import pytest
from scipy import stats
from solved import study

from lockprobe.statistics.outcomes import Point
from lockprobe.statistics.trend import correlation, resample, trend

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
    fit, loops = trend(data, "success", drawn(data)), trend(data, "loop_rate", 1 - drawn(data))
    assert fit.value == pytest.approx([0.7 - 4 * (x - 0.4) ** 2 for x in fit.dose])
    assert (fit.turning, fit.kind) == (pytest.approx(0.4), "maximum")
    assert (loops.turning, loops.kind) == (pytest.approx(0.4), "minimum")


def test_the_band_is_the_spread_of_fits_to_the_resamples():
    data = points(lambda x: 0.5 + x / 3, noise=0.1)
    draws = drawn(data)
    fit, x = trend(data, "success", draws), np.array([d.dose for d in data])
    curves = [np.polyval(np.polyfit(x, row, 2), fit.dose) for row in draws]
    assert fit.low == pytest.approx(np.percentile(curves, 2.5, axis=0).tolist())
    assert fit.high == pytest.approx(np.percentile(curves, 97.5, axis=0).tolist())
    assert trend(data, "success", NONE).low == ()


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
    for constant_or_few in (np.full(5, 0.5), np.arange(4.0), np.empty(0)):
        n = len(constant_or_few)
        assert correlation(np.arange(float(n)), constant_or_few, (np.empty((0, n)),) * 2) is None


def test_the_same_trial_at_another_p_is_drawn_with_it():
    played = study(np.repeat(np.random.default_rng(1).random((1, 1, 30)) < 0.5, 2, axis=0))
    drawn = resample(played, np.random.default_rng(2))["success"]
    assert np.array_equal(drawn[:, 0], drawn[:, 1])
