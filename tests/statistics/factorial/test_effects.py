"""Effects of factors against a regression, and shares of variance against stated ones."""

import numpy as np
import pytest

from lockprobe.statistics.factorial import effects
from lockprobe.statistics.factorial.design import fraction

SIGNS = np.array(fraction(8), dtype=np.float64)
FACTORS = [f"f{i}" for i in range(8)]
LUCK = np.random.default_rng(3)


def sheets(slopes, blocks, interaction=0.0):
    """Blocks of trials whose chance of 1 depends on the factors, half a slope up or down."""
    chance = 0.5 + SIGNS @ np.array(slopes) / 2 + interaction * SIGNS[:, 0] * SIGNS[:, 1]
    return (LUCK.random((blocks, 16)) < chance).astype(np.float64)


def test_effects_are_those_of_a_regression():
    values = sheets([0.3, 0, 0, 0.1, 0, 0, 0, 0], 30)
    found, _ = effects._of_measure(values, SIGNS, FACTORS, "success")
    design = np.column_stack([np.ones(16 * 30), np.tile(SIGNS, (30, 1))])
    slopes = np.linalg.lstsq(design, values.ravel(), rcond=None)[0][1:]
    assert [one.value for one in found] == pytest.approx(list(2 * slopes))


def test_no_factor_is_detected_in_more_than_one_of_twenty_studies_of_none(monkeypatch):
    monkeypatch.setattr(effects, "_DRAWS", 2)
    wrong = 0
    for _ in range(200):
        found, _ = effects._of_measure(sheets([0] * 8, 10), SIGNS, FACTORS, "success")
        wrong += any(one.p_value < 0.05 for one in found)
    assert wrong / 200 <= 0.05 + 3 * (0.05 * 0.95 / 200) ** 0.5


def test_shares_of_variance_are_those_of_the_true_means_whatever_the_noise():
    slopes, rest = np.array([0.0, 0.3, 0, 0, 0.15, 0, 0, 0]), 0.1
    squares = np.array([*(slopes / 2) ** 2, rest**2])
    true = squares / squares.sum()
    for blocks in (20, 400):
        drawn = [effects._variance(sheets(slopes, blocks, rest), SIGNS) for _ in range(60)]
        mean = np.mean([[*shares, left] for shares, left in drawn], axis=0)
        assert mean == pytest.approx(true, abs=0.08 if blocks == 20 else 0.02)


def test_nothing_that_varies_has_no_shares():
    found, rest = effects._of_measure(np.zeros((10, 16)), SIGNS, FACTORS, "misreading")
    assert rest is None
    assert {(one.value, one.p_value, one.variance) for one in found} == {(0.0, None, None)}


def test_a_trial_without_a_statement_is_left_out_of_its_block():
    values = sheets([0.4, 0, 0, 0, 0, 0, 0, 0], 20)
    values[3, 5] = np.nan
    found, _ = effects._of_measure(values, SIGNS, FACTORS, "misreading")
    by_hand = np.nanmean(values[:, SIGNS[:, 0] > 0], axis=1) - np.nanmean(values[:, SIGNS[:, 0] < 0], axis=1)
    assert found[0].value == pytest.approx(by_hand.mean())
