"""Grids are drawn as they are: a cell for each combination, in words that fit."""

from itertools import product

import numpy as np
import pytest

from lockprobe.report.figures.dose_grid import cell_lines, dose_grid
from lockprobe.report.rows import Estimate, Fact, Results
from lockprobe.statistics.proportions import proportion

AXIS = "flip rate \N{MULTIPLICATION SIGN} tremble p"


def grid(rows, columns, *, without=()):
    """A grid in whose cells none, one, two, … of 20 trials were solved."""
    doses = {"first doses": rows, "second doses": columns}
    facts = {name: ", ".join(f"{dose:g}" for dose in own) for name, own in doses.items()}
    facts |= {"first dose": "flip rate", "second dose": "tremble p"}
    made = []
    for i, (row, column) in enumerate(product(rows, columns)):
        share = proportion(min(i, 20), 20)
        numbers = {name: getattr(share, name) for name in ("value", "low", "high", "count", "n")}
        of = {"agent": "llm:$\\frac{" + "x" * 80, "axis": AXIS, "of": f"{row:g}, {column:g}"}
        if (row, column) not in without:
            made.append(Estimate(quantity="success_in_grid", **of, **numbers))
    known = [Fact(about=AXIS, name=name, text=text) for name, text in facts.items()]
    return Results.model_construct(rows=made, facts=known)


def drawn(found):
    figure = dose_grid(found, AXIS)
    figure.draw_without_rendering()
    (axes,) = figure.axes
    return axes


def test_every_cell_says_share_count_and_interval():
    axes = drawn(grid((0, 0.4), (0, 0.1)))
    assert [text.get_text() for text in axes.texts] == [
        "0 %\n0/20\n[0, 16]", "5 %\n1/20\n[1, 24]", "10 %\n2/20\n[3, 30]", "15 %\n3/20\n[5, 36]",
    ]  # fmt: skip
    assert (axes.get_ylabel(), axes.get_xlabel()) == ("flip rate $p$", "tremble p")


def test_a_combination_without_trials_is_a_cross():
    axes = drawn(grid((0, 0.4), (0, 0.1), without={(0.4, 0.1)}))
    assert axes.texts[-1].get_text() == "\N{MULTIPLICATION SIGN}"
    assert "interaction not estimated" in axes.get_title(loc="left")


@pytest.mark.parametrize("columns", [2, 3, 4, 5, 6, 8])
def test_what_stands_in_a_cell_fits_into_it(columns):
    axes = drawn(grid((0, 0.2, 0.4), [round(0.05 * i, 2) for i in range(columns)]))
    for text, patch in zip(axes.texts, axes.patches, strict=True):
        room, taken = patch.get_window_extent(), text.get_window_extent()
        assert taken.width <= room.width
        assert taken.height <= room.height


def test_more_columns_have_fewer_lines():
    cell = grid((0, 0.4), (0, 0.1)).rows[0]
    assert [len(cell_lines(cell, columns)) for columns in (4, 5, 7)] == [3, 2, 1]


def test_more_success_is_darker():
    axes = drawn(grid((0, 0.2, 0.4), (0, 0.1, 0.2)))
    light = [float(np.dot(patch.get_facecolor()[:3], (0.3, 0.6, 0.1))) for patch in axes.patches]
    assert light == sorted(light, reverse=True)
