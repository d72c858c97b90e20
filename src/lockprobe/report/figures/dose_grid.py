"""Success over two doses at once: a cell for each combination, and the interaction as a number."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from itertools import product

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from lockprobe.foundation.formatting import bracketed, p_value, percent
from lockprobe.report.figures.compose import sheet
from lockprobe.report.figures.frame import axis_label, safe_name, title
from lockprobe.report.figures.settings import FAINT, INK, own_settings
from lockprobe.report.prose.subject import Subject
from lockprobe.report.rows import Estimate, Results

_COLOURS = mpl.colormaps["Blues"]

_DARK = 0.78
"""Share from which on white is easier to read on its colour than ink."""

_LONGEST = 38
"""Characters of a name above a panel."""

_WHOLE, _SHORT = 4, 6
"""Columns up to which a cell has room for its interval, and for its count."""

_LINE, _AROUND = 0.155, 1.25
"""Height of a line of text in a cell, and of what stands around the cells, in inches."""


@own_settings()
def dose_grid(found: Results, axis: str) -> Figure | None:
    """The grid of this axis, a panel for each agent."""
    facts = found.facts_about(axis)
    rows, columns = (facts[f"{place} doses"].split(", ") for place in ("first", "second"))
    players = list(dict.fromkeys((row.agent, row.modality) for row in found.where("success_in_grid", axis=axis)))
    lines = 3 if len(columns) <= _WHOLE else 2 if len(columns) <= _SHORT else 1
    height = _AROUND + len(rows) * _LINE * (lines + 0.9)
    return sheet(players, partial(_draw, found, axis, rows, columns), heights=[height], cells=True)


def cell_lines(cell: Estimate, columns: int) -> list[str]:
    """What stands in a cell: the share, the count and the interval, as far as there is room."""
    lines = [
        percent(cell.value),
        f"{cell.count}/{cell.n}",
        f"[{100 * (cell.low or 0):.0f}, {100 * (cell.high or 0):.0f}]",
    ]
    return lines if columns <= _WHOLE else lines[:2] if columns <= _SHORT else [lines[0].removesuffix(" %")]


def _draw(
    found: Results, axis: str, rows: Sequence[str], columns: Sequence[str], axes: Axes, player: tuple[str, str]
) -> None:
    """Share of trials solved under every combination of doses; darker is more. A cross is not played."""
    own = {"agent": player[0], "modality": player[1], "axis": axis}
    cells = {row.of: row for row in found.where("success_in_grid", **own)}
    for (i, row), (j, column) in product(enumerate(rows), enumerate(columns)):
        cell = cells.get(f"{row}, {column}")
        share = 0.0 if cell is None or cell.value is None else cell.value
        face = "white" if cell is None else _COLOURS(0.85 * share)
        axes.add_patch(Rectangle((j - 0.5, i - 0.5), 1, 1, facecolor=face, edgecolor="white", linewidth=1.5))
        text = "\N{MULTIPLICATION SIGN}" if cell is None else "\n".join(cell_lines(cell, len(columns)))
        colour = FAINT if cell is None else "white" if share > _DARK else INK
        axes.text(j, i, text, ha="center", va="center", color=colour, linespacing=1.15)
    first, second = (axis_label(found.facts_about(axis)[f"{place} dose"]) for place in ("first", "second"))
    axes.set(xlim=(-0.5, len(columns) - 0.5), ylim=(len(rows) - 0.5, -0.5), xlabel=second, ylabel=first)
    axes.set_xticks(range(len(columns)), columns)
    axes.set_yticks(range(len(rows)), rows)
    axes.spines[:].set_visible(False)
    axes.tick_params(length=0)
    title(axes, safe_name(Subject.of(player[0]).name, _LONGEST), _interaction(found.get("success_interaction", **own)))


def _interaction(found: Estimate | None) -> str:
    if found is None or found.value is None:
        return "interaction not estimated"
    return f"interaction {bracketed(found.value, found.low, found.high)} points, {p_value(found.p_value, '$P$')}"
