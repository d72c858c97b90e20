"""A forest plot: a row for each estimate, its name and its numbers above its bar, and a thin line between two rows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import accumulate, product

from matplotlib.axes import Axes
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextToPath
from matplotlib.transforms import ScaledTranslation

from lockprobe.report.figures.compose import COLUMN
from lockprobe.report.figures.palette import Dash, Style
from lockprobe.report.figures.primitives import Interval, estimates
from lockprobe.report.figures.settings import FAINT, INK, SMALL

_BAR, _LINE, _APART = 0.16, 0.165, 0.06
"""Height of a bar, of a line of text, and of what stands between two rows, in inches."""

_DESCENT = 0.03
"""How far letters reach below their line, in inches."""

_ROOM, _BETWEEN = COLUMN - 0.45, 0.12
"""Width above a bar in a panel of a column, and at least so much between name and numbers, in inches."""

_AXIS, _TITLE = 0.58, 0.145
"""Height of the named axis below the rows, and of a line of the title above them, in inches."""

_BORDER = "#dddddd"
"""Of the line between two rows."""


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


def height(rows: Sequence[ForestRow], wide: float = _ROOM) -> float:
    """How high axes with these rows are, with so much width above their bars, in inches."""
    return sum(_row(row, wide) for row in rows)


def around(lines: int) -> float:
    """Height of what stands around the axes, in inches: a title of so many lines and a named axis."""
    return _AXIS + _TITLE * lines


def _row(row: ForestRow, wide: float) -> float:
    return _APART + _LINE * _lines(row, wide) + _BAR


def _lines(row: ForestRow, wide: float) -> int:
    """Lines above a bar: the name's, and one more where there is no room for the numbers."""
    names = row.name.split("\n")
    return len(names) + (_width(names[-1]) + _BETWEEN + _width(row.said) > wide)


@lru_cache(1024)
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
    room: float = 0.0,
    wide: float = _ROOM,
) -> list[float]:
    """Draw the rows, the first on top, and their axis below the last. An estimate outside the limits is an arrow.

    Args:
        axes: Where.
        rows: What.
        limits: Of the horizontal axis.
        left: Where names begin, in widths of the axes; below 0 they begin left of them.
        levels: Values to compare with, each with colour and dash: upright lines that stop where text stands.
        room: Height of the axes in inches, where they are as high as others with more rows.
        wide: Width above a bar, in inches.

    Returns:
        The height of each mark, in inches from the top.
    """
    ends = list(accumulate(_row(row, wide) for row in rows))
    places = [end - _BAR / 2 for end in ends]
    for place, row in zip(places, rows, strict=True):
        _draw(axes, place, row, limits)
        _write(axes, place, row, left, wide)
    for place, (value, colour, dash) in product(places, levels):
        upright = [place - 0.4 * _BAR, place + 0.5 * _BAR]
        axes.plot([value, value], upright, color=colour, linestyle=dash, linewidth=0.9, zorder=1)
    across = axes.get_yaxis_transform()
    axes.hlines(ends[:-1], left, 1.0, color=_BORDER, linewidth=0.6, transform=across, clip_on=False, zorder=0)
    axes.set(xlim=limits, ylim=(max(room, ends[-1]), 0.0), yticks=[])
    axes.spines["left"].set_visible(False)
    if room > ends[-1]:
        axes.spines["bottom"].set_position(("data", ends[-1]))
    return places


def _draw(axes: Axes, place: float, row: ForestRow, limits: tuple[float, float]) -> None:
    """The mark of a row and its bar."""
    value, style = row.found.value, row.style
    if value is None:
        return
    inside = limits[0] <= value <= limits[1]
    estimates(axes, [place], [row.found], style, across=True, markersize=4.8, marker=style.marker if inside else "")
    if not inside:
        edge, marker = (limits[0], "<") if value < limits[0] else (limits[1], ">")
        axes.plot(edge, place, **style.line | {"marker": marker, "markersize": 4.8, "clip_on": False})


def _write(axes: Axes, place: float, row: ForestRow, left: float, wide: float) -> None:
    """The name of a row on its left, and its numbers on its right, both above its bar at a distance of print."""
    above = range(_lines(row, wide))[::-1]
    texts = [(left, name, "left", INK, lines) for name, lines in zip(row.name.split("\n"), above, strict=False)]
    texts.append((1.0, row.said, "right", INK if row.style.lead else FAINT, 0))
    for x, text, side, colour, lines in texts:
        up = ScaledTranslation(0.0, 0.5 * _BAR + _DESCENT + _LINE * lines, axes.figure.dpi_scale_trans)
        across = axes.get_yaxis_transform() + up
        axes.text(x, place, text, transform=across, ha=side, va="baseline", color=colour, zorder=2)
