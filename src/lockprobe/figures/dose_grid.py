"""Success over two doses at once: a cell for each combination, and the interaction as a number."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from lockprobe.analysis.dose_grid import GridCell, GridSummary
from lockprobe.figures.forest import interval
from lockprobe.figures.frame import FAINT, INK, SMALL, axis_label, safe_name, shortened, title
from lockprobe.formatting import p_value, percent

__all__ = ["GridPanel", "cell_lines", "draw_grid", "grid_height"]

GridPanel = tuple[str, GridSummary]
"""What a panel is headed by, and the grid that it shows."""

_COLOURS = mpl.colormaps["Blues"]

_DARK = 0.55
"""Share from which on text on its colour is white."""

_LONGEST = 38
"""Characters of a name above a panel."""

_WHOLE, _SHORT = 4, 6
"""Columns up to which a cell has room for its interval, and for its count."""

_LINE, _AROUND = 0.155, 1.25
"""Height of a line of text in a cell, and of what stands around the cells, in inches."""


def cell_lines(cell: GridCell, columns: int) -> list[str]:
    """What stands in a cell: the share, the count and the interval, as far as there is room."""
    success = cell.success
    lines = [
        percent(success.value),
        f"{success.count}/{success.n}",
        f"[{100 * success.low:.0f}, {100 * success.high:.0f}]",
    ]
    return lines if columns <= _WHOLE else lines[:2] if columns <= _SHORT else [lines[0].removesuffix(" %")]


def grid_height(panels: Sequence[GridPanel]) -> float:
    """How high axes have to be for these grids, in inches."""
    return max(
        _AROUND + len(one.grid.row_doses) * _LINE * (len(cell_lines(one.cells[0], len(one.grid.column_doses))) + 0.9)
        for _, one in panels
    )


def draw_grid(axes: Axes, panel: GridPanel) -> None:
    """Share of trials solved under every combination of doses; darker is more. A cross is not played."""
    name, found = panel
    grid = found.grid
    played = {(cell.row, cell.column): cell for cell in found.cells}
    columns = len(grid.column_doses)
    for i, row in enumerate(grid.row_doses):
        for j, column in enumerate(grid.column_doses):
            cell = played.get((row, column))
            share = 0.0 if cell is None else cell.success.value
            face = "white" if cell is None else _COLOURS(0.85 * share)
            axes.add_patch(Rectangle((j - 0.5, i - 0.5), 1, 1, facecolor=face, edgecolor="white", linewidth=1.5))
            text = "\N{MULTIPLICATION SIGN}" if cell is None else "\n".join(cell_lines(cell, columns))
            colour = FAINT if cell is None else "white" if share > _DARK else INK
            axes.text(j, i, text, ha="center", va="center", fontsize=SMALL, color=colour, linespacing=1.15)
    axes.set_xlim(-0.5, columns - 0.5)
    axes.set_ylim(len(grid.row_doses) - 0.5, -0.5)
    axes.set_xticks(range(columns), [f"{dose:g}" for dose in grid.column_doses])
    axes.set_yticks(range(len(grid.row_doses)), [f"{dose:g}" for dose in grid.row_doses])
    axes.set_xlabel(axis_label(grid.columns), fontsize=SMALL, color=INK)
    axes.set_ylabel(axis_label(grid.rows), fontsize=SMALL, color=INK)
    axes.spines[:].set_visible(False)
    axes.tick_params(labelcolor=INK, labelsize=SMALL, length=0)
    title(axes, safe_name(shortened(name, _LONGEST)), _interaction(found))


def _interaction(found: GridSummary) -> str:
    change = found.interaction
    if change is None:
        return "interaction not estimated"
    return f"interaction {interval(change.value, change.low, change.high)} points, {p_value(change.p_value, '$P$')}"
