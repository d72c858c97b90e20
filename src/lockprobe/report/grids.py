"""Grids of crossed doses: their rows of ``results.json``, their tables, and the sentence on each interaction."""

from __future__ import annotations

from collections.abc import Sequence

from lockprobe.analysis.effects import Effects
from lockprobe.analysis.grid import GridSummary
from lockprobe.analysis.speaking import p_said, points_said
from lockprobe.report.format import NONE, TextTable, p_cell, percent, points_cell
from lockprobe.report.schema import GridAxis, GridCellResult, GridResult

__all__ = ["grid_rows", "grid_said", "grid_table", "trend_table"]

_TWO_BY_TWO = 4
"""Cells of the smallest grid, in which the interaction is the difference of differences."""


def grid_rows(found: Effects) -> list[GridResult]:
    """The grids of one agent as rows of ``results.json``."""
    return [_row(found, one) for one in found.grids]


def _row(found: Effects, one: GridSummary) -> GridResult:
    grid, change = one.grid, one.interaction
    return GridResult(
        agent=found.agent,
        modality=found.modality,
        name=grid.name,
        rows=GridAxis(intervention=grid.rows.kind, dose=grid.rows.dose, values=list(grid.row_doses)),
        columns=GridAxis(intervention=grid.columns.kind, dose=grid.columns.dose, values=list(grid.column_doses)),
        rest=grid.rows.rest,
        cells=[
            GridCellResult(
                row=cell.row,
                column=cell.column,
                condition=cell.condition,
                trials=cell.success.n,
                solved=cell.success.count,
                success=cell.success.value,
                success_low=cell.success.low,
                success_high=cell.success.high,
            )
            for cell in one.cells
        ],
        trials=change.pairs if change else 0,
        difference=change.value if change else None,
        difference_low=change.low if change else None,
        difference_high=change.high if change else None,
        p_value=change.p_value if change else None,
        corrected_for=one.choices,
        detectable=one.detectable,
    )


def grid_said(one: GridSummary) -> str:
    """Whether one intervention does something else at other doses of the other, in a sentence."""
    grid, change = one.grid, one.interaction
    first, second = grid.rows.name, grid.columns.name
    beside = f", with {grid.rows.rest}" if grid.rows.rest else ""
    if change is None:
        why = "no trial has ended under every combination" if grid.complete else "some combinations are not played"
        return f"Whether {second} does something else at other values of {first}{beside} is not told: {why}."
    interval = (
        ""
        if change.low is None or change.high is None
        else f"{_level(one)} interval {points_said(change.low)} to {points_said(change.high)}; "
    )
    test = "not tested" if change.p_value is None else p_said(change.p_value)
    lines = (
        "" if len(grid.conditions) == _TWO_BY_TWO else f"; on straight lines through {len(grid.conditions)} conditions"
    )
    lowest, highest = grid.row_doses[0], grid.row_doses[-1]
    size = f"{points_said(change.value)} points ({interval}{test}{lines})"
    doses = f"{grid.column_doses[0]:g} to {grid.column_doses[-1]:g}"
    what = f"what {second} from {doses} does at {highest:g} less at {lowest:g}"
    if one.detectable:
        return f"What {second} does changes with {first}{beside}: {what} is {size}."
    return f"That {second} does something else at other values of {first}{beside} is not detectable: {what} is {size}."


def _level(one: GridSummary) -> str:
    return "95 %" if one.choices == 1 else f"{100 - 5 / one.choices:.3g} %"


def grid_table(grids: Sequence[GridResult]) -> TextTable:
    """Every cell of every grid, from the rows of ``results.json``."""
    head = ["agent", "grid", "first dose", "second dose", "condition", "solved", "success"]
    return [head] + [
        [
            row.agent,
            row.name,
            f"{cell.row:g}",
            f"{cell.column:g}",
            cell.condition,
            f"{cell.solved} of {cell.trials}",
            f"{percent(cell.success, 0)} [{percent(cell.success_low, 0)}, {percent(cell.success_high, 0)}]",
        ]
        for row in grids
        for cell in row.cells
    ]


def trend_table(grids: Sequence[GridResult]) -> TextTable:
    """The interaction of every grid, from the rows of ``results.json``."""
    head = ["agent", "grid", "beside", "blocks", "interaction, points", "P", "says"]
    table = [head] + [
        [
            row.agent,
            row.name,
            row.rest or NONE,
            str(row.trials),
            points_cell(row.difference, row.difference_low, row.difference_high),
            p_cell(row.p_value),
            NONE if row.difference is None else "shown" if row.detectable else "not shown",
        ]
        for row in grids
    ]
    kept = [i for i in range(len(head)) if i != 2 or any(row.rest for row in grids)]
    return [[row[i] for i in kept] for row in table]
