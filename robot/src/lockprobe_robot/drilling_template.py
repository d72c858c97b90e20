"""A drilling template: the front of a box's board in true scale, to be printed, glued on wood and drilled.

Every dimension comes from the panel layout from which the twin's MuJoCo model is built.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle, FancyArrowPatch, Patch, Polygon, Rectangle
from numpy.typing import NDArray

from lockprobe.boxes.box import Lockbox
from lockprobe.foundation.storage.atomic_file import write_file
from lockprobe.report.figures.frame import FAINT, INK, settable
from lockprobe.report.figures.settings import own_settings
from lockprobe.trial.plan import LABELS
from lockprobe_robot.scene.mounted_joint import KNOB_RADIUS, PIVOT_RADIUS, TRACK_RADIUS, MountedJoint
from lockprobe_robot.scene.panel import PanelLayout, lay_out_panel
from lockprobe_robot.scene.tag_layout import QUIET_ZONE, TagLayout, place_tags
from lockprobe_robot.true_scale import A3, POINT, draw_ruler, larger_than, sheet, true_scale_file, write_note

__all__ = ["drilling_template", "exceeds_a3", "write_template"]

_MARGIN, _STRIP = 6.0, 34.0
"""Around the board, and to its right for the ruler and the notes, millimetres."""

_CROSS, _BESIDE = 10.0, 16.0
"""Half the length of a cross, and from its middle to the words next to it, millimetres."""

_THIN: dict[str, Any] = {"fill": False, "edgecolor": INK, "linewidth": 0.4}
_BOLD: dict[str, Any] = {**_THIN, "linewidth": 0.8}
"""How outlines are drawn; those in bold are cut or drilled."""

_CAP_POINTS = 65
_CAP = 0.72
"""Height of a capital letter as a share of the size of its font."""

Point = tuple[float, float]


def write_template(box: Lockbox, path: Path) -> str:
    """Write the drilling template of a box, as SVG or PDF by the file's name.

    Returns:
        A warning if it is larger than A3, or nothing.
    """
    panel = lay_out_panel(box)
    figure = drilling_template(panel, LABELS[: len(box.joints)], place_tags(panel), box.name)
    write_file(path, true_scale_file(figure, "pdf" if path.suffix == ".pdf" else "svg"))
    if not exceeds_a3(panel):
        return ""
    width, height = (1000 * side for side in panel.size)
    return f"the board of {width:g} x {height:g} mm with its margins is larger than A3"


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
    _add(axes, Rectangle((_MARGIN, _MARGIN), width, height, **_BOLD), "board")
    for number, (mounted, label, place) in enumerate(zip(panel.mounted_joints, labels, panel.labels, strict=True)):
        (_slider if mounted.kind == "prismatic" else _lever)(axes, panel, mounted, number)
        size = 1000 * panel.letter / POINT / _CAP
        axes.text(*_on_sheet(panel, place), label, fontsize=size, ha="center", va="center", color="#bbbbbb")
    for number, middle in enumerate(tags.middles):
        _tag(axes, _on_sheet(panel, middle), 1000 * tags.side, number)
    right = width + 2 * _MARGIN
    write_note(axes, right, _MARGIN, _notes(panel, tags, name), va="top", ha="left", rotation=90, linespacing=1.4)
    draw_ruler(axes, right + _STRIP - 8.0, _MARGIN, upright=True)
    return figure


def _sheet_size(panel: PanelLayout) -> tuple[float, float]:
    width, height = (1000 * side for side in panel.size)
    return width + 2 * _MARGIN + _STRIP, height + 2 * _MARGIN


def _on_sheet(panel: PanelLayout, point: NDArray[np.float64]) -> Point:
    """A point of the panel's frame, metres, on the sheet, millimetres."""
    x, y = 1000 * (np.asarray(point) + np.array(panel.size) / 2) + _MARGIN
    return float(x), float(y)


def _moved(point: Point, length: float, angle: float) -> Point:
    """A point so far from another in the direction of an angle, radians."""
    return point[0] + length * math.cos(angle), point[1] + length * math.sin(angle)


def _add(axes: Axes, patch: Patch, name: str = "") -> None:
    patch.set_gid(name or None)
    axes.add_patch(patch)


def _words(axes: Axes, place: Point, words: str, *, va: str = "center", turn: float = 0.0) -> None:
    """Words in the middle of a place, never upside down."""
    write_note(axes, *place, words, ha="center", va=va, rotation=(turn + 90) % 180 - 90)


def _handle(axes: Axes, middle: Point, number: int, position: str) -> None:
    """The outline of a handle at one end of its travel."""
    look = {**_THIN, "edgecolor": FAINT, "linewidth": 0.6, "linestyle": "-" if position == "closed" else (0, (3, 2))}
    _add(axes, Circle(middle, 1000 * KNOB_RADIUS, **look), f"handle-{number}-{position}")


def _hole(axes: Axes, middle: Point, *, below: bool = True) -> None:
    """A cross where a hole is drilled, and its distances from the board's left and lower edge."""
    x, y = middle
    axes.plot([x - _CROSS, x + _CROSS], [y, y], color=INK, linewidth=0.4)
    axes.plot([x, x], [y - _CROSS, y + _CROSS], color=INK, linewidth=0.4)
    place = (x, y - _BESIDE) if below else (x, y + _BESIDE)
    _words(axes, place, f"x {x - _MARGIN:.1f}, y {y - _MARGIN:.1f}", va="top" if below else "bottom")


def _slider(axes: Axes, panel: PanelLayout, mounted: MountedJoint, number: int) -> None:
    """The slot of a slider, with its ends and its travel."""
    start, middle, end = (_on_sheet(panel, mounted.knob(fraction)) for fraction in (0.0, 0.5, 1.0))
    across, half = mounted.direction - math.pi / 2, np.linspace(0, math.pi, _CAP_POINTS)
    caps = [(start, across + math.pi + half), (end, across + half)]
    outline = [_moved(point, 1000 * TRACK_RADIUS, angle) for point, angles in caps for angle in angles]
    _add(axes, Polygon(outline, closed=True, **_BOLD), f"slot-{number}")
    for point, position in ((start, "closed"), (end, "open")):
        _hole(axes, point, below=(position == "closed") == (start[1] <= end[1]))
        _handle(axes, point, number, position)
    style: dict[str, Any] = {"arrowstyle": "-|>", "mutation_scale": 8, "shrinkA": 0, "shrinkB": 0}
    _add(axes, FancyArrowPatch(start, end, linewidth=0.4, color=INK, **style))
    words = f"{1000 * mounted.travel:g} mm"
    _words(axes, _moved(middle, 11, across), words, turn=math.degrees(mounted.direction))


def _lever(axes: Axes, panel: PanelLayout, mounted: MountedJoint, number: int) -> None:
    """The axis of a lever, and the swing of its handle."""
    pivot = _on_sheet(panel, np.array(mounted.origin))
    _add(axes, Circle(pivot, 1000 * PIVOT_RADIUS, **_BOLD), f"axis-{number}")
    _hole(axes, pivot)
    radius, first, swing = 1000 * mounted.reach, math.degrees(mounted.direction), math.degrees(mounted.travel)
    arc = Arc(pivot, 2 * radius, 2 * radius, theta1=first, theta2=first + swing, edgecolor=INK, linewidth=0.8)
    _add(axes, arc, f"swing-{number}")
    for fraction, position in ((0.0, "closed"), (1.0, "open")):
        middle = _on_sheet(panel, mounted.knob(fraction))
        axes.plot(*zip(pivot, middle, strict=True), color=FAINT, linewidth=0.4)
        _handle(axes, middle, number, position)
    between = _moved(pivot, 0.55 * radius, mounted.direction + mounted.travel / 2)
    _words(axes, between, f"{swing:.1f}°\nr {radius:g} mm")


def _tag(axes: Axes, middle: Point, side: float, number: int) -> None:
    """The black square of a tag and its white border, both as outlines, and its number."""
    for length, name, dash in ((side, f"tag-{number}", "-"), ((1 + 2 * QUIET_ZONE) * side, "", ":")):
        corner = (middle[0] - length / 2, middle[1] - length / 2)
        _add(axes, Rectangle(corner, length, length, linestyle=dash, **_THIN), name)
    x, y = middle[0] - _MARGIN, middle[1] - _MARGIN
    _words(axes, middle, f"tag {number}, {side:g} mm\nthis side up\nmiddle x {x:.1f}, y {y:.1f}")


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
