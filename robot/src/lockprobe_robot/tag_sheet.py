"""A sheet of AprilTags in true scale, to be printed on A4, cut out and glued on a board."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch, Rectangle
from matplotlib.path import Path
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue
from lockprobe.report.figures.settings import FAINT, own_settings
from lockprobe_robot.true_scale import A4, draw_ruler, sheet, write_note

__all__ = ["tag_sheet"]

_MARGIN, _FOOT, _GAP = 15.0, 30.0, 12.0
"""Around the tags, below them for the ruler, and between them for their names, millimetres."""


@own_settings()
def tag_sheet(bits: NDArray[np.bool_], numbers: Sequence[int], side: float) -> Figure:
    """Draw tags on a sheet of A4 in upright format.

    Below each tag stand its family, number and size. The dotted line around the white border is where it is cut.

    Args:
        bits: Cells of each tag, True for white, shape (tags, cells, cells), the upper row first.
        numbers: The tags' numbers.
        side: Side of a tag's black square, millimetres.

    Raises:
        BadValue: If the tags do not fit on the sheet.
    """
    height, width = A4
    whole = side * (1 + 2 / bits.shape[1])
    step = whole + _GAP
    columns = int((width - 2 * _MARGIN + _GAP) // step)
    rows = int((height - 2 * _MARGIN - _FOOT) // step)
    if len(numbers) > columns * rows:
        raise BadValue("tags", f"{len(numbers)} of {side:g} mm", f"at most {columns * rows} of this size on A4")
    figure, axes = sheet(width, height)
    for index, number in enumerate(numbers):
        row, column = divmod(index, columns)
        corner = (_MARGIN + column * step, height - _MARGIN - whole - row * step)
        _tag(axes, bits[index], corner, whole, f"AprilTag 36h11, number {number}: {side:g} mm")
    write_note(axes, _MARGIN, _FOOT - 6, _note(side), va="bottom")
    draw_ruler(axes, _MARGIN, _FOOT - 18)
    return figure


def _tag(axes: Axes, cells: NDArray[np.bool_], corner: tuple[float, float], whole: float, words: str) -> None:
    """One tag in the middle of its white border. All black cells are one path, so that no gap shows between them."""
    cell = whole / (len(cells) + 2)
    axes.add_patch(Rectangle(corner, whole, whole, fill=False, edgecolor=FAINT, linewidth=0.3, linestyle=":"))
    square = np.array([(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)])
    lower_left = np.argwhere(~cells)[:, ::-1] * (1, -1) + (1, len(cells))
    squares = corner + cell * (lower_left[:, None] + square)
    black = Path.make_compound_path(*(Path(one, closed=True) for one in squares))
    axes.add_patch(PathPatch(black, facecolor="black", edgecolor="none"))
    write_note(axes, corner[0] + whole / 2, corner[1] - 1.5, words, ha="center", va="top")


def _note(side: float) -> str:
    return (
        f"Measure a black square after printing: {side:g} mm. If it differs, give the measured size to "
        "lockprobe rig calibrate --tag-size.\nWrite the number and an arrow up on the back of each tag. Cut along the "
        "dotted lines, and glue each tag flat\nwhere the drilling template has its number, upright as printed here."
    )
