"""Fractional factorial designs: orthogonal columns, their recognition by specs, and effects against a regression."""

from itertools import combinations

import numpy as np
import pytest
from builders import SOLUTION, make_trial

from lockprobe.statistics.factorial import factorial_effects, factorial_of, main_effects
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.study_design import design_of

FULL = ["tremble?p=0.2", "flip?p=0.4", "nudge"]
EIGHT = [" + ".join(one) for size in (1, 2, 3) for one in combinations(FULL, size)]
SCENES = study("looks").conditions
FACTORS = [*SCENES[-1].plant.options]
SIGNS = np.array([[1.0 if name in one.plant.options else -1.0 for name in FACTORS] for one in SCENES])


def test_no_factor_of_the_study_looks_is_mixed_with_another_or_an_interaction_of_two():
    assert (SIGNS.shape, len({*map(tuple, SIGNS)}), {*SIGNS[0]}) == ((16, 8), 16, {-1})
    pairs = [first * second for first, second in combinations(SIGNS.T, 2)]
    for column in SIGNS.T:
        assert column.sum() == 0
        assert not any(column @ pair for pair in pairs)


def designed(conditions):
    return design_of(study("flips", agent="random", p=[0], condition=conditions))


def found_in(conditions):
    return factorial_of(designed(conditions).arms)


def test_a_full_design_of_three_is_one_and_what_is_unbalanced_or_has_two_factors_is_none():
    found = found_in(EIGHT)
    assert sorted(found.levels) == ["flip.p", "nudge", "tremble.p"]
    assert found.levels["flip.p"] == "0.4"
    assert found.runs["truth"] == (-1, -1, -1)
    assert sum(levels[[*found.levels].index("nudge")] for levels in found.runs.values()) == 0
    assert found_in(EIGHT[:-1]) is None
    assert found_in(["tremble?p=0.2", "flip?p=0.4", "tremble?p=0.2 + flip?p=0.4"]) is None
    assert found_in([one.replace("flip?p=0.4 + nudge", "flip?p=0.2 + nudge") for one in EIGHT]) is None


def sheet(slopes, blocks, seed=3):
    """Blocks of trials whose chance of 1 depends on the factors, half a slope up or down."""
    chance = 0.5 + SIGNS @ np.array(slopes) / 2
    return (np.random.default_rng(seed).random((blocks, 16)) < chance).astype(np.float64)


def test_effects_are_those_of_a_regression():
    values = sheet([0.3, 0, 0, 0.1, 0, 0, 0, 0], 30)
    slopes = np.linalg.lstsq(np.column_stack([np.ones(480), np.tile(SIGNS, (30, 1))]), values.ravel(), rcond=None)[0]
    assert [one.value for one in main_effects(values, SIGNS)] == pytest.approx(2 * slopes[1:])


def test_where_nothing_varies_nothing_is_tested_and_a_trial_without_a_statement_is_left_out_of_its_block():
    still = main_effects(np.zeros((10, 16)), SIGNS)
    assert {(one.value, one.low, one.p_value) for one in still} == {(0.0, None, None)}
    values = sheet([0.4, 0, 0, 0, 0, 0, 0, 0], 20)
    values[3, 5] = np.nan
    by_hand = np.nanmean(values[:, SIGNS[:, 0] > 0], axis=1) - np.nanmean(values[:, SIGNS[:, 0] < 0], axis=1)
    assert main_effects(values, SIGNS)[0].value == pytest.approx(by_hand.mean())


@pytest.mark.parametrize("broke", ["truth", "tremble?p=0.2 + nudge"])
def test_effects_on_success_hold_whatever_became_of_broken_trials(broke):
    labels = ["truth", *EIGHT]
    solved = np.random.default_rng(8).random((8, 8)) < [0.2 + 0.5 * ("tremble" in label) for label in labels]
    cells = {
        ("random", label): [
            make_trial([0], trial=i + 1, broken="model")
            if (label, i) == (broke, 0)
            else make_trial(SOLUTION if solved[i, column] else [0] * 20, trial=i + 1)
            for i in range(8)
        ]
        for column, label in enumerate(labels)
    }
    (found,) = (
        one
        for one in factorial_effects(cells, designed(EIGHT))
        if (one.factor, one.measure) == ("tremble.p", "success")
    )
    change, runs = found.change, found_in(EIGHT).runs
    assert (change.clusters, change.n) == (7, 56)
    signs, at = np.array([*runs.values()]), [*found_in(EIGHT).levels].index("tremble.p")
    values = solved[:, [labels.index(label) for label in runs]].astype(float)
    ends = []
    for end in (0.0, 1.0):
        values[0, [*runs].index(broke)] = end
        ends.append(main_effects(values, signs)[at])
    assert change.value == main_effects(values[1:], signs)[at].value
    assert (change.low, change.high) == (min(end.low for end in ends), max(end.high for end in ends))
    assert change.p_value >= max(end.p_value for end in ends)
