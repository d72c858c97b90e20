"""Sheets in true scale: figures in millimetres, a ruler to check the print, and files that keep the scale."""

from __future__ import annotations

import io
import re
from typing import Any, Literal

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lockprobe.figures.frame import INK
from lockprobe.figures.settings import own_settings

__all__ = ["A3", "A4", "NOTE", "POINT", "RULER", "draw_ruler", "larger_than", "sheet", "true_scale_file"]

A3, A4 = (420.0, 297.0), (297.0, 210.0)
"""Sides of paper, millimetres, the longer one first."""

RULER = 100.0
"""Length of the ruler on every sheet, millimetres."""

NOTE = 7.0
"""Size of notes, points."""

_INCH = 25.4
POINT = _INCH / 72
"""One typographic point in millimetres."""

_NOTED: dict[str, Any] = {"fontsize": NOTE, "color": INK, "va": "bottom", "rotation_mode": "anchor"}


def sheet(width: float, height: float) -> tuple[Figure, Axes]:
    """An empty sheet whose axes have the unit millimetre and their origin in the lower left corner."""
    figure = Figure(figsize=(width / _INCH, height / _INCH))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(0, width), ylim=(0, height))
    axes.set_axis_off()
    return figure, axes


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

    def line(first: tuple[float, float], last: tuple[float, float], name: str = "") -> None:
        (drawn,) = axes.plot(*zip(at(*first), at(*last), strict=True), color=INK, linewidth=0.6, solid_capstyle="butt")
        if name:
            drawn.set_gid(name)

    turn = 90.0 if upright else 0.0
    line((0, 0), (RULER, 0), "ruler")
    for tick in range(0, int(RULER) + 1, 10):
        high = 4.0 if tick % 50 == 0 else 2.5
        line((tick, 0), (tick, high))
        if tick % 50 == 0:
            axes.text(*at(tick, 4.6), str(tick), ha="center", **_NOTED, rotation=turn)
    axes.text(*at(RULER + 6, 0), "mm. Print at 100 %, and measure this ruler.", ha="left", **_NOTED, rotation=turn)


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
    text = re.sub(r'(<svg[^>]*?) width="[^"]*"', rf'\1 width="{width:g}mm"', out.getvalue().decode(), count=1)
    return re.sub(r'(<svg[^>]*?) height="[^"]*"', rf'\1 height="{height:g}mm"', text, count=1).encode()
