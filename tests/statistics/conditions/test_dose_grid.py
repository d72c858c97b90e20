"""Crossed doses are found in the specs, and their interaction is what a least-squares fit gives."""

from itertools import product

import numpy as np
import pytest

from lockprobe.foundation.spec import Spec
from lockprobe.interventions.conditions import read_condition, sweep
from lockprobe.statistics.conditions.dose_grid import grids, trend_weights
from lockprobe.statistics.conditions.series import SeriesArm


def arms(*specs):
    conditions = [one for spec in specs for one in (sweep(spec) if "," in spec else (read_condition(spec),))]
    return [
        SeriesArm(label=one.label, specs=tuple(map(Spec.parse, one.specs)), doses=one.dose_names, modality=one.modality)
        for one in conditions
    ]


def test_a_crossed_sweep_is_a_grid_with_the_truth_in_its_corner():
    (grid,) = grids(arms("flip?p=0,0.2,0.4 + tremble?p=0,0.1"))
    assert (grid.row_doses, grid.column_doses) == ((0, 0.2, 0.4), (0, 0.1))
    assert [*grid.weights] == [*grid.conditions.values()]
    assert grid.name == "flip rate \N{MULTIPLICATION SIGN} tremble p"
    assert grid.conditions[0.0, 0.0] == "truth"
    assert grid.conditions[0.4, 0.1] == "flip?p=0.4 + tremble?p=0.1"


def test_a_combination_that_is_missing_leaves_the_interaction_without_weights():
    (grid,) = grids(arms("truth", "flip?p=0.4", "flip?p=0.4 + tremble?p=0.1", "flip?p=0.2 + tremble?p=0.1"))
    assert grid.weights == {}


def test_doses_that_were_never_crossed_and_interventions_without_doses_are_no_grid():
    assert grids(arms("truth", "flip?p=0.2,0.4", "tremble?p=0.1,0.2")) == ()
    assert grids(arms("truth", "nudge", "flip?p=0.4", "nudge + flip?p=0.4")) == ()
    assert grids(arms("truth", "flip?p=0.4 + tremble?p=0.1")) == ()  # one dose each


def test_other_interventions_beside_make_other_grids():
    found = grids(arms("flip?p=0,0.4 + tremble?p=0,0.1", "flip?p=0,0.4 + tremble?p=0,0.1 + nudge"))
    assert [grid.rows.rest for grid in found] == ["", "nudge"]
    assert found[1].conditions[0.0, 0.0] == "nudge"


def test_three_doses_crossed_are_grids_at_every_dose_of_the_third():
    found = grids(arms("flip?p=0,0.4 + tremble?p=0,0.1 + drop?p=0,0.3"))
    assert len(found) == 6
    assert all(len(grid.weights) == 4 for grid in found)


@pytest.mark.parametrize(
    ("rows", "columns"),
    [((0, 0.4), (0, 0.1)), ((0, 0.2, 0.4), (0, 0.1, 0.2)), ((0, 0.05, 0.4), (0, 0.1, 0.3, 0.35)), ((1, 2, 5), (0, 3))],
)
def test_the_contrast_is_the_slope_over_both_doses_by_least_squares(rows, columns):
    values = np.random.default_rng(2).random(len(rows) * len(columns))
    weights, factor = trend_weights(rows, columns)
    places = list(product(range(len(rows)), range(len(columns))))
    design = np.array(
        [
            [*(i == a for a in range(len(rows))), *(j == b for b in range(1, len(columns))), rows[i] * columns[j]]
            for i, j in places
        ],
        dtype=float,
    )
    slope = np.linalg.lstsq(design, values, rcond=None)[0][-1]
    expected = slope * (rows[-1] - rows[0]) * (columns[-1] - columns[0])
    assert float(factor) * np.dot(weights, values) == pytest.approx(expected)
