"""Tests of a U: known numbers, symmetry, and how often they are wrong."""

from dataclasses import replace

import numpy as np
import pytest
from known_truth import Design, simulated
from solved import columns, people
from statsmodels.genmod.families import Binomial
from statsmodels.genmod.generalized_linear_model import GLM

from lockprobe.foundation.seeds import generator
from lockprobe.statistics.two_lines import two_lines

EXPECTED = (7, 12, 16, 19, 20, 18, 15)
SATURATING = (0.23, 0.38, 0.53, 0.62, 0.667, 0.667, 0.667)


def trials(solved, n=30, p=None):
    p = np.arange(len(solved)) / 10 if p is None else np.asarray(p)
    solved = np.concatenate([np.arange(n) < k for k in solved])
    return columns(np.repeat(p, n), np.arange(len(solved)) + 1, solved=solved)


def wald(p, solved):
    fit = GLM(solved.astype(float), np.column_stack([np.ones(len(p)), p]), family=Binomial()).fit()
    return fit.params[1], fit.pvalues[1]


def test_the_lines_share_the_break_and_their_tests_are_near_those_of_logit_regressions():
    """Of the expected counts of the paper."""
    played = trials(EXPECTED)
    p, lines = played.dose, two_lines(played)
    assert (lines.break_p, lines.direction) == (0.3, None)
    assert 0.1 < lines.p_value < 0.3
    for line, side in ((lines.first, p <= lines.break_p), (lines.second, p >= lines.break_p)):
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


@pytest.mark.parametrize("truth", [(0.05,) * 7, SATURATING, (0.5,) * 3])
def test_two_lines_hold_their_level_when_nothing_falls(truth):
    rng = np.random.default_rng(1)
    p_values = [two_lines(trials(rng.binomial(30, truth))).p_value for _ in range(400)]
    assert np.mean([value is not None and value <= 0.05 for value in p_values]) <= 0.05 + 2 * np.sqrt(0.05 * 0.95 / 400)


def test_people_who_play_at_one_p_only_are_no_u():
    """Six people with ten boxes at each p: as independent trials a rise and fall is seen in a quarter of studies."""
    seen = []
    for seed in range(80):
        played = people(np.random.default_rng(seed), 6, 10, 0.5)
        alone, together = two_lines(replace(played, player=played.player[:0])), two_lines(played)
        assert together.p_value >= alone.p_value - 1e-9
        seen.append((alone.direction is not None, together.direction is not None))
    independent, clustered = np.mean(seen, axis=0)
    assert independent > 0.15
    assert clustered <= 0.05


def drawn(name, trials=30, seed=1):
    return simulated(name, generator(seed, name), Design(repetitions=1, trials=trials))


def test_loops_that_come_later_and_then_sooner_are_a_u_of_loop_onset():
    found = two_lines(drawn("loops-return"), "first loops")
    assert (found.direction, found.break_p) == ("U", 0.3)
    assert found.first.z < -3 < 3 < found.second.z
    assert found.p_value == max(found.first.p_value, found.second.p_value) < 1e-3
    once = two_lines(drawn("loop-trapped", trials=100), "first loops")
    assert (once.first.z < -5, once.direction) == (True, None)


def test_trial_length_alone_bends_loop_rates_and_not_loop_onset():
    """Success rises and falls, so loop rates fall and rise; the hazard of a loop is the same at every p."""
    played = drawn("inverted-u", trials=300)
    assert two_lines(replace(played, solved=played.looped)).direction == "U"
    assert two_lines(played, "first loops").direction is None
    seen = [two_lines(drawn("inverted-u", seed=seed), "first loops").direction is not None for seed in range(100)]
    assert np.mean(seen) <= 0.05 + 2 * np.sqrt(0.05 * 0.95 / 100)
