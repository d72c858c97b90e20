"""Effects of factors against a regression."""

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
    found = effects._of_measure(values, SIGNS, FACTORS, "success")
    design = np.column_stack([np.ones(16 * 30), np.tile(SIGNS, (30, 1))])
    slopes = np.linalg.lstsq(design, values.ravel(), rcond=None)[0][1:]
    assert [one.value for one in found] == pytest.approx(list(2 * slopes))


def test_no_factor_is_detected_in_more_than_one_of_twenty_studies_of_none():
    wrong = 0
    for _ in range(200):
        found = effects._of_measure(sheets([0] * 8, 10), SIGNS, FACTORS, "success")
        wrong += any(one.p_value < 0.05 for one in found)
    assert wrong / 200 <= 0.05 + 3 * (0.05 * 0.95 / 200) ** 0.5


def test_where_nothing_varies_nothing_is_tested():
    found = effects._of_measure(np.zeros((10, 16)), SIGNS, FACTORS, "misreading")
    assert {(one.value, one.p_value) for one in found} == {(0.0, None)}


def test_a_trial_without_a_statement_is_left_out_of_its_block():
    values = sheets([0.4, 0, 0, 0, 0, 0, 0, 0], 20)
    values[3, 5] = np.nan
    found = effects._of_measure(values, SIGNS, FACTORS, "misreading")
    by_hand = np.nanmean(values[:, SIGNS[:, 0] > 0], axis=1) - np.nanmean(values[:, SIGNS[:, 0] < 0], axis=1)
    assert found[0].value == pytest.approx(by_hand.mean())
