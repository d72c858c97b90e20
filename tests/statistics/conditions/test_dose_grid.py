"""Crossed doses are found in the specs, and their interaction is what a least-squares fit gives."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from builders import SOLUTION, make_trial

from lockprobe.foundation.spec import Spec
from lockprobe.interventions.conditions import read_condition, sweep
from lockprobe.statistics.conditions.dose_grid import contrast, grid_summary, grids
from lockprobe.statistics.conditions.series import SeriesArm
from lockprobe.statistics.outcomes import outcomes


def arms(*specs):
    conditions = [one for spec in specs for one in (sweep(spec) if "," in spec else (read_condition(spec),))]
    return [
        SeriesArm(label=one.label, specs=tuple(map(Spec.parse, one.specs)), doses=one.dose_names, modality=one.modality)
        for one in conditions
    ]


def trials(solved):
    return outcomes([make_trial(SOLUTION if one else [0] * 20, trial=i, budget=20) for i, one in enumerate(solved, 1)])


def drawn(grid, chances, n=40, seed=1):
    """Trials under every condition of a grid, solved by chance."""
    rng = np.random.default_rng(seed)
    return {name: trials(rng.random(n) < chances[place]) for place, name in grid.conditions.items()}


def summary(grid, found, broken=None, **more):
    """The results on a grid; without broken trials unless given."""
    none = {name: one.at(np.zeros(len(one), dtype=bool)) for name, one in found.items()}
    return grid_summary(grid, found, broken or none, **more)


def test_a_crossed_sweep_is_a_grid_with_the_truth_in_its_corner():
    (grid,) = grids(arms("flip?p=0,0.2,0.4 + tremble?p=0,0.1"))
    assert (grid.row_doses, grid.column_doses, grid.complete) == ((0, 0.2, 0.4), (0, 0.1), True)
    assert grid.name == "flip rate \N{MULTIPLICATION SIGN} tremble p"
    assert grid.conditions[0.0, 0.0] == "truth"
    assert grid.conditions[0.4, 0.1] == "flip?p=0.4 + tremble?p=0.1"


def test_a_combination_that_is_missing_leaves_the_interaction_untold():
    (grid,) = grids(arms("truth", "flip?p=0.4", "flip?p=0.4 + tremble?p=0.1", "flip?p=0.2 + tremble?p=0.1"))
    assert not grid.complete
    found = summary(grid, drawn(grid, dict.fromkeys(grid.conditions, 0.5)))
    assert found.interaction is None
    assert len(found.cells) == len(grid.conditions)


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
    assert all(grid.complete and len(grid.conditions) == 4 for grid in found)


@pytest.mark.parametrize(
    ("rows", "columns"),
    [((0, 0.4), (0, 0.1)), ((0, 0.2, 0.4), (0, 0.1, 0.2)), ((0, 0.05, 0.4), (0, 0.1, 0.3, 0.35)), ((1, 2, 5), (0, 3))],
)
def test_the_contrast_is_the_slope_over_both_doses_by_least_squares(rows, columns):
    values = np.random.default_rng(2).random(len(rows) * len(columns))
    weights, factor = contrast(rows, columns)
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


def test_what_adds_up_is_no_interaction_and_correction_only_widens():
    (grid,) = grids(arms("flip?p=0,0.2,0.4 + tremble?p=0,0.1,0.2"))
    found = drawn(grid, {(row, column): 0.2 + row + column for row, column in grid.conditions}, n=60)
    one, ten = summary(grid, found), summary(grid, found, choices=10)
    assert not one.detectable
    assert ten.interaction.low < one.interaction.low <= one.interaction.value == ten.interaction.value
    assert ten.interaction.p_value == min(1, 10 * one.interaction.p_value)


def test_under_no_interaction_the_test_keeps_its_level():
    (grid,) = grids(arms("flip?p=0,0.2,0.4 + tremble?p=0,0.1"))
    template = trials([True] * 20)
    shown, rng = 0, np.random.default_rng(3)
    for _ in range(400):
        played = {name: replace(template, solved=rng.random(20) < 0.5) for name in grid.conditions.values()}
        shown += summary(grid, played).detectable
    assert shown / 400 < 0.07


def test_only_blocks_with_a_trial_in_every_cell_count():
    (grid,) = grids(arms("flip?p=0,0.4 + tremble?p=0,0.1"))
    found = drawn(grid, dict.fromkeys(grid.conditions, 0.5))
    found["truth"] = found["truth"].at(np.arange(40) < 7)
    assert summary(grid, found).interaction.pairs == 7
    assert summary(grid, {**found, "truth": found["truth"].at(np.zeros(7, dtype=bool))}).interaction is None


def test_broken_trials_count_for_an_interaction_at_one_end_and_against_it_at_the_other():
    """Five trials of each cell broke: as the four cells with these solved or not, by the sign of their weight."""
    (grid,) = grids(arms("flip?p=0,0.4 + tremble?p=0,0.1"))
    whole, broke = drawn(grid, dict.fromkeys(grid.conditions, 0.5)), np.arange(40) < 5
    ended, broken = ({name: one.at(of) for name, one in whole.items()} for of in (~broke, broke))
    weights, _ = contrast(grid.row_doses, grid.column_doses)
    ends = [
        summary(
            grid,
            {
                name: replace(whole[name], solved=np.where(broke, (weight > 0) == high, whole[name].solved))
                for name, weight in zip(grid.conditions.values(), weights, strict=True)
            },
        )
        for high in (False, True)
    ]
    low, high = (one.interaction for one in ends)
    made = summary(grid, ended, broken)
    assert made.interaction.low == min(low.low, high.low)
    assert made.interaction.high == max(low.high, high.high)
    assert made.interaction.p_value == 1.0
    assert not made.detectable
    for cell in made.cells:
        assert (cell.success.n, cell.success.broken) == (35, 5)
