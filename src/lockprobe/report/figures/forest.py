"""A forest plot: one row per estimate, with its interval, its name above it and its numbers at the right."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

from matplotlib.axes import Axes
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextToPath

from lockprobe.report.figures.frame import FAINT, INK, SMALL
from lockprobe.report.figures.palette import Dash, Style
from lockprobe.report.figures.primitives import Interval, estimates

__all__ = ["ForestRow", "forest", "height"]

_BAR, _LINE = 0.17, 0.165
"""Height of a bar and of a line of text, in inches."""

_ROOM, _BETWEEN = 2.8, 0.12
"""Width above a bar, and at least so much between name and numbers, in inches."""


@dataclass(frozen=True, slots=True)
class ForestRow:
    """One estimate.

    Attributes:
        name: Set above it, left.
        said: Set above it, right.
        found: Its value and its interval; without a value it has no mark, without both ends no bar.
        style: Of mark and bar.
    """

    name: str
    said: str
    found: Interval
    style: Style


def height(rows: Sequence[ForestRow]) -> float:
    """How high axes with these rows have to be, in inches, with a title and a named axis."""
    return 0.85 + len(rows) * _row(rows)


def _row(rows: Sequence[ForestRow]) -> float:
    return _BAR + _LINE * max((_lines(row) for row in rows), default=1)


def _lines(row: ForestRow) -> int:
    """Lines above a bar: the name's, and one more where there is no room for the numbers."""
    names = row.name.split("\n")
    return len(names) + (max(map(_width, names)) + _BETWEEN + _width(row.said) > _ROOM)


def _width(text: str) -> float:
    """How wide a text is as it is set, in inches."""
    font = FontProperties(size=SMALL)
    width, _, _ = TextToPath().get_text_width_height_descent(text.replace(r"\$", "S"), font, ismath="$P$" in text)
    return float(width) / 72


def forest(
    axes: Axes,
    rows: Sequence[ForestRow],
    limits: tuple[float, float],
    *,
    left: float = 0.0,
    levels: Sequence[tuple[float, str, Dash]] = (),
) -> None:
    """Draw the rows, the first on top. An estimate outside the limits is an arrow at the edge.

    Args:
        axes: Where.
        rows: What.
        limits: Of the horizontal axis.
        left: Where names begin, in widths of the axes; below 0 they begin left of them.
        levels: Values to compare with, each with colour and dash: upright lines that stop where text stands.
    """
    inches = _row(rows)
    for i, row in enumerate(rows):
        _draw(axes, i, row, limits)
        _write(axes, i, row, left, inches)
    for i, (value, colour, dash) in product(range(len(rows)), levels):
        ends = [i - 0.7 * _BAR / inches, i + 0.5 * _BAR / inches]
        axes.plot([value, value], ends, color=colour, linestyle=dash, linewidth=0.9, zorder=1)
    axes.set(xlim=limits, ylim=(len(rows) - 1 + 0.6 * _BAR / inches, 0.25 * _BAR / inches - 1), yticks=[])
    axes.spines["left"].set_visible(False)


def _draw(axes: Axes, i: int, row: ForestRow, limits: tuple[float, float]) -> None:
    """The mark of a row and its bar."""
    value, style = row.found.value, row.style
    if value is None:
        return
    inside = limits[0] <= value <= limits[1]
    estimates(axes, [i], [row.found], style, across=True, markersize=4.8, marker=style.marker if inside else "")
    if not inside:
        edge, marker = (limits[0], "<") if value < limits[0] else (limits[1], ">")
        axes.plot(edge, i, **style.line | {"marker": marker, "markersize": 4.8, "clip_on": False})


def _write(axes: Axes, i: int, row: ForestRow, left: float, inches: float) -> None:
    """The name of a row on its left, and its numbers on its right."""
    above = _LINE * (_lines(row) - row.name.count("\n") - 1)
    for x, text, side, colour, more in (
        (left, row.name, "left", INK, above),
        (1.0, row.said, "right", INK if row.style.lead else FAINT, 0.0),
    ):
        y, across = i - (0.75 * _BAR + more) / inches, axes.get_yaxis_transform()
        axes.text(x, y, text, transform=across, ha=side, va="bottom", color=colour, linespacing=1.1, zorder=2)
