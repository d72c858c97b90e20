"""Grids are drawn as they are: a cell for each combination, in words that fit."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from lockprobe.analysis.dose_grid import GridCell, GridSummary, grids
from lockprobe.analysis.proportions import proportion
from lockprobe.analysis.series import SeriesArm
from lockprobe.figures.dose_grid import cell_lines, draw_grid, grid_height
from lockprobe.interventions.condition import sweep
from lockprobe.spec import Spec


def summary(rows, columns, *, without=()):
    spec = f"flip?p={','.join(map(str, rows))} + tremble?p={','.join(map(str, columns))}"
    arms = [
        SeriesArm(label=one.label, specs=tuple(map(Spec.parse, one.specs)), doses=one.dose_names) for one in sweep(spec)
    ]
    (grid,) = grids(arms)
    cells = tuple(
        GridCell(row=row, column=column, condition=name, success=proportion(min(i, 20), 20))
        for i, ((row, column), name) in enumerate(grid.conditions.items())
        if (row, column) not in without
    )
    return GridSummary(grid=grid, cells=cells, interaction=None, choices=1)


def drawn(found, width=3.5):
    panel = ("llm:$\\frac{" + "x" * 80, found)
    figure = Figure(figsize=(width, grid_height([panel])), layout="constrained")
    axes = figure.subplots()
    draw_grid(axes, panel)
    figure.draw_without_rendering()
    return axes


def test_every_cell_says_share_count_and_interval():
    axes = drawn(summary((0, 0.4), (0, 0.1)))
    assert [text.get_text() for text in axes.texts] == [
        "0 %\n0/20\n[0, 16]", "5 %\n1/20\n[1, 24]", "10 %\n2/20\n[3, 30]", "15 %\n3/20\n[5, 36]",
    ]  # fmt: skip


def test_a_combination_without_trials_is_a_cross():
    axes = drawn(summary((0, 0.4), (0, 0.1), without={(0.4, 0.1)}))
    assert axes.texts[-1].get_text() == "\N{MULTIPLICATION SIGN}"


@pytest.mark.parametrize("columns", [2, 3, 4, 5, 6, 8])
def test_what_stands_in_a_cell_fits_into_it(columns):
    found = summary((0, 0.2, 0.4), [round(0.05 * i, 2) for i in range(columns)])
    axes = drawn(found)
    for text, patch in zip(axes.texts, axes.patches, strict=True):
        room, taken = patch.get_window_extent(), text.get_window_extent()
        assert taken.width <= room.width
        assert taken.height <= room.height


def test_more_columns_have_fewer_lines():
    cell = summary((0, 0.4), (0, 0.1)).cells[0]
    assert [len(cell_lines(cell, columns)) for columns in (4, 5, 7)] == [3, 2, 1]


def test_more_success_is_darker():
    axes = drawn(summary((0, 0.2, 0.4), (0, 0.1, 0.2)))
    light = [float(np.dot(patch.get_facecolor()[:3], (0.3, 0.6, 0.1))) for patch in axes.patches]
    assert light == sorted(light, reverse=True)
