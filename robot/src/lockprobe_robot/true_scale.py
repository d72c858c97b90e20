"""Sheets in true scale: figures in millimetres, a ruler to check the print, and files that keep the scale."""

from __future__ import annotations

import io
import re
from typing import Any, Literal

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lockprobe.report.figures.frame import INK
from lockprobe.report.figures.settings import own_settings

__all__ = ["A3", "A4", "POINT", "RULER", "draw_ruler", "larger_than", "sheet", "true_scale_file", "write_note"]

A3, A4 = (420.0, 297.0), (297.0, 210.0)
"""Sides of paper, millimetres, the longer one first."""

RULER = 100.0
"""Length of the ruler on every sheet, millimetres."""

_NOTE = 7.0
"""Size of notes, points."""

_INCH = 25.4
POINT = _INCH / 72
"""One typographic point in millimetres."""


def sheet(width: float, height: float) -> tuple[Figure, Axes]:
    """An empty sheet whose axes have the unit millimetre and their origin in the lower left corner."""
    figure = Figure(figsize=(width / _INCH, height / _INCH))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(0, width), ylim=(0, height))
    axes.set_axis_off()
    return figure, axes


def write_note(axes: Axes, x: float, y: float, words: str, **settings: Any) -> None:
    """Small words at a place in millimetres; settings are those of ``Axes.text``."""
    axes.text(x, y, words, fontsize=_NOTE, rotation_mode="anchor", **settings)


def draw_ruler(axes: Axes, left: float, bottom: float, *, upright: bool = False) -> None:
    """A ruler of 100 mm with a tick every 10 mm, and what it is for.

    Args:
        axes: The sheet.
        left: Where the ruler begins, millimetres.
        bottom: Where the ruler begins, millimetres.
        upright: Whether it runs upwards and is read from the right.
    """

    def at(along: float, aside: float) -> tuple[float, float]:
        return (left - aside, bottom + along) if upright else (left + along, bottom + aside)

    line: dict[str, Any] = {"color": INK, "linewidth": 0.6, "solid_capstyle": "butt"}
    note: dict[str, Any] = {"va": "bottom", "rotation": 90.0 if upright else 0.0}
    axes.plot(*zip(at(0, 0), at(RULER, 0), strict=True), gid="ruler", **line)
    for tick in range(0, int(RULER) + 1, 10):
        named = tick % 50 == 0
        axes.plot(*zip(at(tick, 0), at(tick, 4.0 if named else 2.5), strict=True), **line)
        if named:
            write_note(axes, *at(tick, 4.6), str(tick), ha="center", **note)
    write_note(axes, *at(RULER + 6, 0), "mm. Print at 100 %, and measure this ruler.", ha="left", **note)


def larger_than(size: tuple[float, float], paper: tuple[float, float]) -> bool:
    """Whether a sheet of this size fits on a paper in neither direction. Millimetres."""
    return max(size) > max(paper) or min(size) > min(paper)


@own_settings()
def true_scale_file(figure: Figure, form: Literal["svg", "pdf"]) -> bytes:
    """The sheet as a file in true scale; an SVG file has its width and height in millimetres.

    Equal figures give equal bytes.
    """
    out = io.BytesIO()
    metadata = {"Date": None} if form == "svg" else {"CreationDate": None}
    figure.savefig(out, format=form, metadata=metadata)
    if form == "pdf":
        return out.getvalue()
    width, height = (side * _INCH for side in figure.get_size_inches())
    size = rf'\1 width="{width:g}mm" height="{height:g}mm"'
    return re.sub(r'(<svg[^>]*?) width="[^"]*" height="[^"]*"', size, out.getvalue().decode(), count=1).encode()
