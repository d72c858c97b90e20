"""Success over two doses at once: a cell for each combination, and the interaction as a number."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from lockprobe.figures.compose import sheet
from lockprobe.figures.frame import FAINT, INK, axis_label, safe_name, title
from lockprobe.figures.settings import own_settings
from lockprobe.formatting import bracketed, p_value, percent
from lockprobe.rows import Estimate, Results

__all__ = ["cell_lines", "dose_grid"]

_COLOURS = mpl.colormaps["Blues"]

_DARK = 0.55
"""Share from which on text on its colour is white."""

_LONGEST = 38
"""Characters of a name above a panel."""

_WHOLE, _SHORT = 4, 6
"""Columns up to which a cell has room for its interval, and for its count."""

_LINE, _AROUND = 0.155, 1.25
"""Height of a line of text in a cell, and of what stands around the cells, in inches."""


@dataclass(frozen=True, slots=True)
class _Panel:
    """One agent: its cells by both doses, and the interaction."""

    name: str
    axes: tuple[str, str]
    doses: tuple[Sequence[str], Sequence[str]]
    cells: Mapping[str, Estimate]
    interaction: Estimate | None


@own_settings()
def dose_grid(found: Results, axis: str) -> Figure | None:
    """The grid of this axis, a panel for each agent."""
    facts = found.facts_about(axis)
    names, doses = (facts["first dose"], facts["second dose"]), (facts["first doses"], facts["second doses"])
    own: dict[tuple[str, str], dict[str, Estimate]] = {}
    for row in found.where("success_in_grid", axis=axis):
        own.setdefault((row.agent, row.modality), {})[row.of] = row
    panels = [
        _Panel(
            name=agent,
            axes=names,
            doses=(doses[0].split(", "), doses[1].split(", ")),
            cells=cells,
            interaction=found.get("success_interaction", agent=agent, modality=modality, axis=axis),
        )
        for (agent, modality), cells in own.items()
    ]
    rows, columns = map(len, panels[0].doses)
    lines = 3 if columns <= _WHOLE else 2 if columns <= _SHORT else 1
    return sheet(panels, _draw, heights=[_AROUND + rows * _LINE * (lines + 0.9)])


def cell_lines(cell: Estimate, columns: int) -> list[str]:
    """What stands in a cell: the share, the count and the interval, as far as there is room."""
    lines = [
        percent(cell.value),
        f"{cell.count}/{cell.n}",
        f"[{100 * (cell.low or 0):.0f}, {100 * (cell.high or 0):.0f}]",
    ]
    return lines if columns <= _WHOLE else lines[:2] if columns <= _SHORT else [lines[0].removesuffix(" %")]


def _draw(axes: Axes, panel: _Panel) -> None:
    """Share of trials solved under every combination of doses; darker is more. A cross is not played."""
    rows, columns = panel.doses
    for i, row in enumerate(rows):
        for j, column in enumerate(columns):
            cell = panel.cells.get(f"{row}, {column}")
            share = 0.0 if cell is None or cell.value is None else cell.value
            face = "white" if cell is None else _COLOURS(0.85 * share)
            axes.add_patch(Rectangle((j - 0.5, i - 0.5), 1, 1, facecolor=face, edgecolor="white", linewidth=1.5))
            text = "\N{MULTIPLICATION SIGN}" if cell is None else "\n".join(cell_lines(cell, len(columns)))
            colour = FAINT if cell is None else "white" if share > _DARK else INK
            axes.text(j, i, text, ha="center", va="center", color=colour, linespacing=1.15)
    first, second = map(axis_label, panel.axes)
    axes.set(xlim=(-0.5, len(columns) - 0.5), ylim=(len(rows) - 0.5, -0.5), xlabel=second, ylabel=first)
    axes.set_xticks(range(len(columns)), columns)
    axes.set_yticks(range(len(rows)), rows)
    axes.spines[:].set_visible(False)
    axes.tick_params(length=0)
    title(axes, safe_name(panel.name, _LONGEST), _interaction(panel.interaction))


def _interaction(found: Estimate | None) -> str:
    if found is None or found.value is None:
        return "interaction not estimated"
    return f"interaction {bracketed(found.value, found.low, found.high)} points, {p_value(found.p_value, '$P$')}"
