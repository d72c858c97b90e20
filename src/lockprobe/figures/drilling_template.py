"""A drilling template: the front of a box's board in true scale, to be printed, glued on wood and drilled.

Every dimension comes from the panel layout from which the twin's MuJoCo model is built.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle, FancyArrowPatch, Polygon, Rectangle
from numpy.typing import NDArray

from lockprobe.figures.frame import FAINT, INK
from lockprobe.figures.interlock import settable
from lockprobe.figures.settings import own_settings
from lockprobe.figures.true_scale import A3, NOTE, POINT, draw_ruler, larger_than, sheet
from lockprobe.plants.scene.mounted_joint import KNOB_RADIUS, PIVOT_RADIUS, TRACK_RADIUS, MountedJoint
from lockprobe.plants.scene.panel import PanelLayout
from lockprobe.plants.scene.tag_layout import QUIET_ZONE, TagLayout

__all__ = ["drilling_template", "exceeds_a3"]

_MARGIN, _STRIP = 6.0, 34.0
"""Around the board, and to its right for the ruler and the notes, millimetres."""

_THIN, _BOLD = 0.4, 0.8
_CROSS, _BESIDE = 10.0, 16.0
"""Half the length of a cross, and from its middle to the words next to it, millimetres."""

_CAP_POINTS = 65
_CAP = 0.72
"""Height of a capital letter as a share of the size of its font."""

_NOTE_STYLE: dict[str, Any] = {"fontsize": NOTE, "color": INK, "linespacing": 1.4, "rotation_mode": "anchor"}

Point = tuple[float, float]


def exceeds_a3(panel: PanelLayout) -> bool:
    """Whether the template of a panel is larger than a sheet of A3."""
    return larger_than(_sheet_size(panel), A3)


@own_settings()
def drilling_template(panel: PanelLayout, labels: Sequence[str], tags: TagLayout, name: str) -> Figure:
    """Draw the front of a board in true scale, 1:1.

    The groups of an SVG file have the names ``board``, ``slot-0``, ``axis-1``, ``handle-1-open``, ``tag-0`` and so on;
    joints count in panel order from 0, tags by their numbers.

    Args:
        panel: The layout of joints and labels.
        labels: One for each joint in panel order.
        tags: Where the AprilTags are glued.
        name: The box's name.
    """
    figure, axes = sheet(*_sheet_size(panel))
    width, height = (1000 * side for side in panel.size)
    board = Rectangle((_MARGIN, _MARGIN), width, height, fill=False, edgecolor=INK, linewidth=_BOLD)
    _add(axes, board, "board")
    for number, (mounted, label, place) in enumerate(zip(panel.mounted_joints, labels, panel.labels, strict=True)):
        (_slider if mounted.kind == "prismatic" else _lever)(axes, panel, mounted, number)
        size = 1000 * panel.letter / POINT / _CAP
        axes.text(*_on_sheet(panel, place), label, fontsize=size, ha="center", va="center", color="#bbbbbb")
    for number, middle in enumerate(tags.middles):
        _tag(axes, _on_sheet(panel, middle), 1000 * tags.side, number)
    right = width + 2 * _MARGIN
    axes.text(right, _MARGIN, _notes(panel, tags, name), va="top", ha="left", rotation=90, **_NOTE_STYLE)
    draw_ruler(axes, right + _STRIP - 8.0, _MARGIN, upright=True)
    return figure


def _sheet_size(panel: PanelLayout) -> tuple[float, float]:
    width, height = (1000 * side for side in panel.size)
    return width + 2 * _MARGIN + _STRIP, height + 2 * _MARGIN


def _on_sheet(panel: PanelLayout, point: NDArray[np.float64]) -> Point:
    """A point of the panel's frame, metres, on the sheet, millimetres."""
    x, y = 1000 * (np.asarray(point) + np.array(panel.size) / 2)
    return float(x) + _MARGIN, float(y) + _MARGIN


def _add(axes: Axes, patch: Arc | Circle | FancyArrowPatch | Polygon | Rectangle, name: str = "") -> None:
    if name:
        patch.set_gid(name)
    axes.add_patch(patch)


def _handle(axes: Axes, middle: Point, number: int, position: str) -> None:
    """The outline of a handle at one end of its travel."""
    dash = "-" if position == "closed" else (0, (3, 2))
    radius = 1000 * KNOB_RADIUS
    circle = Circle(middle, radius, fill=False, edgecolor=FAINT, linewidth=1.5 * _THIN, linestyle=dash)
    _add(axes, circle, f"handle-{number}-{position}")


def _hole(axes: Axes, middle: Point, *, below: bool = True) -> None:
    """A cross where a hole is drilled, and its distances from the board's left and lower edge."""
    for dx, dy in ((_CROSS, 0), (0, _CROSS)):
        axes.plot([middle[0] - dx, middle[0] + dx], [middle[1] - dy, middle[1] + dy], color=INK, linewidth=_THIN)
    x, y = middle[0] - _MARGIN, middle[1] - _MARGIN
    place = (middle[0], middle[1] + (-_BESIDE if below else _BESIDE))
    va = "top" if below else "bottom"
    axes.text(*place, f"x {x:.1f}, y {y:.1f}", fontsize=NOTE, ha="center", va=va, color=INK)


def _slider(axes: Axes, panel: PanelLayout, mounted: MountedJoint, number: int) -> None:
    """The slot of a slider, with its ends and its travel."""
    start, end = (_on_sheet(panel, mounted.knob(fraction)) for fraction in (0.0, 1.0))
    ahead = np.linspace(-math.pi / 2, math.pi / 2, _CAP_POINTS) + mounted.direction
    caps = [
        1000 * TRACK_RADIUS * np.stack([np.cos(turns), np.sin(turns)], axis=-1) + middle
        for turns, middle in ((ahead + math.pi, start), (ahead, end))
    ]
    slot = Polygon(np.concatenate(caps), closed=True, fill=False, edgecolor=INK, linewidth=_BOLD)
    _add(axes, slot, f"slot-{number}")
    for point, position in ((start, "closed"), (end, "open")):
        _hole(axes, point, below=(position == "closed") == (start[1] <= end[1]))
        _handle(axes, point, number, position)
    arrow = FancyArrowPatch(
        start, end, arrowstyle="-|>", mutation_scale=8, shrinkA=0, shrinkB=0, linewidth=_THIN, color=INK
    )
    _add(axes, arrow)
    middle, across = _on_sheet(panel, mounted.knob(0.5)), mounted.direction - math.pi / 2
    words = f"{1000 * mounted.travel:g} mm"
    _dimension(
        axes,
        (middle[0] + 11 * math.cos(across), middle[1] + 11 * math.sin(across)),
        words,
        math.degrees(mounted.direction),
    )


def _lever(axes: Axes, panel: PanelLayout, mounted: MountedJoint, number: int) -> None:
    """The axis of a lever, and the swing of its handle."""
    pivot = _on_sheet(panel, np.array(mounted.origin))
    _add(axes, Circle(pivot, 1000 * PIVOT_RADIUS, fill=False, edgecolor=INK, linewidth=_BOLD), f"axis-{number}")
    _hole(axes, pivot)
    radius, first = 1000 * mounted.reach, math.degrees(mounted.direction)
    swing = math.degrees(mounted.travel)
    arc = Arc(pivot, 2 * radius, 2 * radius, theta1=first, theta2=first + swing, edgecolor=INK, linewidth=_BOLD)
    _add(axes, arc, f"swing-{number}")
    for fraction, position in ((0.0, "closed"), (1.0, "open")):
        middle = _on_sheet(panel, mounted.knob(fraction))
        axes.plot(*zip(pivot, middle, strict=True), color=FAINT, linewidth=_THIN)
        _handle(axes, middle, number, position)
    between = mounted.direction + mounted.travel / 2
    place = (pivot[0] + 0.55 * radius * math.cos(between), pivot[1] + 0.55 * radius * math.sin(between))
    _dimension(axes, place, f"{swing:.1f}°\nr {radius:g} mm", 0.0)


def _dimension(axes: Axes, place: Point, words: str, turn: float) -> None:
    """A dimension, never upside down."""
    upright = (turn + 90) % 180 - 90
    axes.text(
        *place, words, fontsize=NOTE, ha="center", va="center", color=INK, rotation=upright, rotation_mode="anchor"
    )


def _tag(axes: Axes, middle: Point, side: float, number: int) -> None:
    """The black square of a tag and its white border, both as outlines, and its number."""
    for length, name, dash in ((side, f"tag-{number}", "-"), ((1 + 2 * QUIET_ZONE) * side, "", ":")):
        corner = (middle[0] - length / 2, middle[1] - length / 2)
        _add(axes, Rectangle(corner, length, length, fill=False, edgecolor=INK, linewidth=_THIN, linestyle=dash), name)
    x, y = middle[0] - _MARGIN, middle[1] - _MARGIN
    words = f"tag {number}, {side:g} mm\nthis side up\nmiddle x {x:.1f}, y {y:.1f}"
    axes.text(*middle, words, fontsize=NOTE, ha="center", va="center", color=INK)


def _notes(panel: PanelLayout, tags: TagLayout, name: str) -> str:
    width, height = (1000 * side for side in panel.size)
    lines = [
        f"{settable(name)}: board {width:g} x {height:g} mm, front, scale 1:1. x, y: mm from its lower left corner.",
        f"Slots {2000 * TRACK_RADIUS:g} mm wide, axes {2000 * PIVOT_RADIUS:g} mm, handles {2000 * KNOB_RADIUS:g} mm.",
        "Handles with a solid outline: closed; dashed: open.",
        f"AprilTags 36h11 of {1000 * tags.side:g} mm (black square), numbers 0 to {len(tags.middles) - 1}.",
    ]
    if exceeds_a3(panel):
        lines.append("This sheet is larger than A3 (420 x 297 mm): print it on a roll or on several sheets.")
    return "\n".join(lines)
