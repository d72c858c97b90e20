"""Grids of crossed doses: their rows of ``results.json`` and their tables."""

from __future__ import annotations

from collections.abc import Sequence

from lockprobe.analysis.dose_grid import GridSummary
from lockprobe.analysis.effects import Effects
from lockprobe.formatting import NONE, bracketed, p_cell, percent
from lockprobe.report.described import filled
from lockprobe.report.format import DETECTED, TextTable
from lockprobe.report.schema import GridAxis, GridCellResult, GridResult

__all__ = ["grid_rows", "grid_table", "trend_table"]


def grid_rows(found: Effects) -> list[GridResult]:
    """The grids of one agent as rows of ``results.json``."""
    return [_row(found, one) for one in found.grids]


def _row(found: Effects, one: GridSummary) -> GridResult:
    grid, change = one.grid, one.interaction
    return filled(
        GridResult,
        found,
        grid,
        one,
        rows=GridAxis(intervention=grid.rows.kind, dose=grid.rows.dose, values=list(grid.row_doses)),
        columns=GridAxis(intervention=grid.columns.kind, dose=grid.columns.dose, values=list(grid.column_doses)),
        rest=grid.rows.rest,
        cells=[
            filled(
                GridCellResult,
                cell,
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
    )


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
    head = ["agent", "grid", "with", "blocks", "interaction, points", "P", "conclusion"]
    table = [head] + [
        [
            row.agent,
            row.name,
            row.rest or NONE,
            str(row.trials),
            bracketed(row.difference, row.difference_low, row.difference_high),
            p_cell(row.p_value),
            NONE if row.difference is None else DETECTED[row.detectable],
        ]
        for row in grids
    ]
    kept = [i for i in range(len(head)) if i != 2 or any(row.rest for row in grids)]
    return [[row[i] for i in kept] for row in table]
