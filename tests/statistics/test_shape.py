"""The shape over doses: the paper's fits, correlation and resamples, and the test of a U with its error rate."""

from dataclasses import replace

import numpy as np
import pytest
from known_truth import simulated
from scipy import stats
from solved import columns, people, study

from lockprobe.foundation.seeds import generator
from lockprobe.statistics.outcomes import Point
from lockprobe.statistics.shape import correlation, resample, trend, two_lines

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


def test_the_fit_is_the_librarys_and_its_band_the_spread_of_fits_to_the_resamples():
    data = points(lambda x: 0.7 - 4 * (x - 0.4) ** 2, noise=0.1)
    draws = drawn(data)
    fit, x = trend(data, "success", draws), np.array([d.dose for d in data])
    curves = [np.polyval(np.polyfit(x, row, 2), fit["x"]) for row in draws]
    assert fit["value"] == pytest.approx(np.polyval(np.polyfit(x, [d.success for d in data], 2), fit["x"]).tolist())
    assert fit["low"] == pytest.approx(np.percentile(curves, 2.5, axis=0).tolist())
    assert fit["high"] == pytest.approx(np.percentile(curves, 97.5, axis=0).tolist())
    assert trend(data, "success", NONE)["low"] == ()


def test_r_and_its_p_value_are_the_librarys():
    rng = np.random.default_rng(1)
    x, y = rng.random((2, 21))
    draws = x + 0.1 * rng.normal(size=(100, 21)), y + 0.1 * rng.normal(size=(100, 21))
    found = correlation(x, y, draws)
    assert (found.value, found.p_value) == pytest.approx(tuple(stats.pearsonr(x, y)))
    resampled = [stats.pearsonr(*pair).statistic for pair in zip(*draws, strict=True)]
    assert (found.low, found.high) == pytest.approx(tuple(np.percentile(resampled, [2.5, 97.5])))
    assert correlation(x, y, (np.empty((0, 21)),) * 2).low is None
    assert (correlation(x, -x, draws).value, correlation(x, -x, draws).p_value) == pytest.approx((-1, 0))
    for constant_or_few in (np.full(5, 0.5), np.arange(3.0), np.empty(0)):
        n = len(constant_or_few)
        assert correlation(np.arange(float(n)), constant_or_few, (np.empty((0, n)),) * 2) is None


def test_the_same_trial_at_another_p_is_drawn_with_it():
    played = study(np.repeat(np.random.default_rng(1).random((1, 1, 30)) < 0.5, 2, axis=0))
    drawn = resample(played, np.random.default_rng(2))["success"]
    assert np.array_equal(drawn[:, 0], drawn[:, 1])


EXPECTED = (7, 12, 16, 19, 20, 18, 15)


def trials(solved, n=30, p=None):
    p = np.arange(len(solved)) / 10 if p is None else np.asarray(p)
    solved = np.concatenate([np.arange(n) < k for k in solved])
    return columns(np.repeat(p, n), np.arange(len(solved)) + 1, solved=solved)


def wald(p, solved):
    from statsmodels.genmod.families import Binomial
    from statsmodels.genmod.generalized_linear_model import GLM

    fit = GLM(solved.astype(float), np.column_stack([np.ones(len(p)), p]), family=Binomial()).fit()
    return fit.params[1], fit.pvalues[1]


def test_the_lines_share_the_break_and_their_tests_are_near_those_of_logit_regressions():
    """Of the expected counts of the paper."""
    played = trials(EXPECTED)
    p, lines = played.dose, two_lines(played)
    assert (lines.value, lines.direction) == (0.3, None)
    assert 0.1 < lines.p_value < 0.3
    for line, side in ((lines.first, p <= lines.value), (lines.second, p >= lines.value)):
        slope, p_value = wald(p[side], played.solved[side])
        assert line.p_value == pytest.approx(p_value, rel=0.3)
        assert np.sign(line.z) == np.sign(slope)
    assert lines.p_value == max(lines.first.p_value, lines.second.p_value)


SHAPES = [
    ((2, 12, 25, 28, 20, 10, 3), "inverted U"),
    ((28, 12, 5, 2, 10, 18, 27), "U"),
    ((2, 6, 10, 14, 18, 22, 26), None),
    ((0, 0, 30, 30, 20, 10), "inverted U"),  # a line that separates has a test
    ((0,) * 7, None),
    ((7, 20), None),
]


@pytest.mark.parametrize(("solved", "shape"), SHAPES)
def test_shape_is_found_where_it_is_plain_and_named(solved, shape):
    assert two_lines(trials(solved)).direction == shape


def test_people_who_play_at_one_p_only_are_no_u():
    """Six people with ten boxes at each p: as independent trials a rise and fall is seen in a quarter of studies."""
    seen = []
    for seed in range(40):
        played = people(np.random.default_rng(seed), 6, 10, 0.5)
        alone, together = two_lines(replace(played, player=played.player[:0])), two_lines(played)
        assert together.p_value >= alone.p_value - 1e-9
        seen.append((alone.direction is not None, together.direction is not None))
    independent, clustered = np.mean(seen, axis=0)
    assert independent > 0.15
    assert clustered <= 0.05


def played(name, trials=30, seed=1):
    return simulated(name, generator(seed, name), repetitions=1, trials=trials)


def test_loops_that_come_later_and_then_sooner_are_a_u_of_loop_onset():
    found = two_lines(played("loops-return"), "first loops")
    assert (found.direction, found.value) == ("U", 0.3)
    assert found.first.z < -3 < 3 < found.second.z
    assert found.p_value == max(found.first.p_value, found.second.p_value) < 1e-3
    once = two_lines(played("loop-trapped", trials=100), "first loops")
    assert (once.first.z < -5, once.direction) == (True, None)
