"""A forest plot: one row per estimate, with its interval, its name above it and its numbers at the right."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

from matplotlib.axes import Axes
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextToPath

from lockprobe.figures.frame import FAINT, INK, SMALL
from lockprobe.figures.palette import Dash, Marker
from lockprobe.formatting import minus

__all__ = ["ForestRow", "differences", "forest", "height", "interval", "reach_of"]

_BAR, _LINE = 0.17, 0.165
"""Height of a bar and of a line of text, in inches."""

_ROOM, _BETWEEN = 2.8, 0.12
"""Width above a bar, and at least so much between name and numbers, in inches."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ForestRow:
    """One estimate.

    Attributes:
        name: Set above it, left.
        said: Set above it, right.
        value: None draws no mark.
        low: Lower end of its interval; None draws none.
        high: Upper end.
        colour: Of mark and bar.
        marker: Of the estimate.
        face: Inside of the marker.
    """

    name: str
    said: str
    value: float | None
    low: float | None
    high: float | None
    colour: str
    marker: Marker = "o"
    face: str


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
        if row.low is not None and row.high is not None:
            axes.plot([row.low, row.high], [i, i], color=row.colour, linewidth=1.3, zorder=3, solid_capstyle="butt")
        if row.value is not None:
            inside = limits[0] <= row.value <= limits[1]
            axes.plot(
                [min(max(row.value, limits[0]), limits[1])],
                [i],
                linestyle="none",
                marker=row.marker if inside else "<" if row.value < limits[0] else ">",
                color=row.colour,
                markersize=4.8,
                markerfacecolor=row.face,
                markeredgewidth=0.9,
                zorder=4,
                clip_on=inside,
            )
        _write(axes, i, row, left, inches)
    for i, (value, colour, dash) in product(range(len(rows)), levels):
        ends = [i - 0.7 * _BAR / inches, i + 0.5 * _BAR / inches]
        axes.plot([value, value], ends, color=colour, linestyle=dash, linewidth=0.9, zorder=1)
    axes.set_xlim(*limits)
    axes.set_ylim(len(rows) - 1 + 0.6 * _BAR / inches, 0.25 * _BAR / inches - 1)
    axes.set_yticks([])
    axes.spines[["top", "right", "left"]].set_visible(False)
    axes.spines["bottom"].set(color="#888888", linewidth=0.7)
    axes.tick_params(color="#888888", labelcolor=INK, labelsize=SMALL, width=0.7, length=3)


def reach_of(rows: Sequence[ForestRow]) -> float:
    """How far an axis around none has to go for these rows, at least 10 points."""
    ends = [end for row in rows for end in (row.value, row.low, row.high) if end is not None]
    return max([*(abs(end) for end in ends), 0.1]) * 1.06


def differences(
    axes: Axes, rows: Sequence[ForestRow], label: str = "difference, points", *, reach: float | None = None
) -> None:
    """Draw differences of shares around a line at none, on an axis in points.

    Args:
        axes: Where.
        rows: What; values lie in [-2, 2].
        label: What stands below the axis.
        reach: Where the axis ends on both sides; as far as these rows need if None.
    """
    reach = reach_of(rows) if reach is None else reach
    forest(axes, rows, (-reach, reach), levels=((0.0, FAINT, "-"),))
    axes.set_xlabel(label, fontsize=SMALL)
    ticks = [tick / 100 for tick in range(-200, 201, 50 if reach > 0.6 else 25 if reach > 0.25 else 10)]
    ticks = [tick for tick in ticks if abs(tick) <= reach]
    axes.set_xticks(ticks, [minus(f"{100 * tick:+.0f}" if tick else "0", zeros=True) for tick in ticks])


def interval(value: float | None, low: float | None, high: float | None) -> str:
    """A difference and its interval in points; empty without one.

    >>> interval(0.27, 0.02, 0.5)
    '+27 [+2, +50]'
    """
    if value is None:
        return ""
    said = f"{100 * value:+.0f}"
    return minus(said if low is None or high is None else f"{said} [{100 * low:+.0f}, {100 * high:+.0f}]", zeros=True)


def _write(axes: Axes, i: int, row: ForestRow, left: float, inches: float) -> None:
    """The name of a row on its left, and its numbers on its right."""
    numbers = FAINT if row.face == "white" else INK
    name = _LINE * (_lines(row) - row.name.count("\n") - 1)
    for x, text, side, colour, above in (
        (left, row.name, "left", INK, name),
        (1.0, row.said, "right", numbers, 0.0),
    ):
        y = i - (0.75 * _BAR + above) / inches
        axes.text(
            x,
            y,
            text,
            transform=axes.get_yaxis_transform(),
            ha=side,
            va="bottom",
            fontsize=SMALL,
            color=colour,
            linespacing=1.1,
            zorder=2,
        )
