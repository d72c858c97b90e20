"""A box as a picture: the panel at the start, and below it what each joint needs, which no agent sees."""

from __future__ import annotations

from itertools import combinations
from math import cos, hypot, pi, sin
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyBboxPatch

from lockprobe.boxes.box import Lockbox
from lockprobe.report.figures.drawing import TARGET, Dash, settable
from lockprobe.report.figures.settings import FAINT, INK, own_settings

Point = tuple[float, float]

_NAME = (0.8, 0.84)
"""Room for a joint with its name, in inches."""

_WIDTHS, _HEIGHTS, _EDGE = (3.2, 6.9), (1.4, 4.3), 0.46
"""Least and greatest size of the panel in inches; how far joints stay from its edge."""

_COLUMN, _ROW, _TOP = 0.87, 0.36, 0.42
"""Width of a column and height of a row of the table of needs, and of its head, in inches."""

_HEAD, _GAP = 0.33, 0.1
"""Height of a heading; below the panel and the table."""

_CLOSE = 0.08
"""Places nearer to each other, in panel sizes, are not drawn: the joints are put in a row."""

_LONGEST = 10
"""Characters in a line of a name."""

_GHOST: Dash = (0, (2, 1.5))
"""How a joint is drawn where it goes when it moves."""


@own_settings()
def box_figure(box: Lockbox) -> Figure:
    """The picture of a box: the panel, and below it a row for each alternative of a joint with the joints it needs."""
    needed, rows = _needed(box), sum(max(1, len(box.alternatives(name))) for name in box.names)
    panel, table = _panel_size(box), (_COLUMN * (1.3 + max(2, len(needed))), _TOP + _ROW * rows)
    width, above = max(panel[0], table[0], 3.4) + 0.1, _GAP + table[1] + 1.5 * _HEAD + _GAP
    height = above + panel[1] + _HEAD
    figure = Figure(figsize=(width, height))
    for draw, bottom, (breadth, high) in ((_draw_panel, above, panel), (_draw_needs, _GAP, table)):
        axes = figure.add_axes((0.05 / width, bottom / height, breadth / width, high / height))
        axes.set(xlim=(0, breadth), ylim=(0, high))
        axes.set_axis_off()
        draw(axes, box)
    return figure


def _needed(box: Lockbox) -> list[str]:
    """The joints that another one waits for."""
    return [one for one in box.names if any(one in clause for name in box.names for clause in box.alternatives(name))]


def _draw_needs(axes: Axes, box: Lockbox) -> None:
    """Filled where a joint has to be open, hollow where it has to be closed; a row for each alternative."""
    columns = {name: _COLUMN * (1.8 + i) for i, name in enumerate(_needed(box))}
    (_, wide), (_, y) = axes.get_xlim(), axes.get_ylim()
    for name, x in columns.items():
        _name_joint(axes, box, name, (x, y - _TOP / 2), ha="center")
    y -= _TOP + _ROW / 2
    for name in box.names:
        for i, clause in enumerate(box.alternatives(name) or [{}]):
            if i:
                axes.text(_COLUMN * 1.15, y, "or", ha="right", va="center")
            else:
                axes.plot([0, wide], [y + _ROW / 2] * 2, color=FAINT, linewidth=0.5)
                _name_joint(axes, box, name, (_COLUMN * 1.15, y), ha="right")
            if not clause:
                axes.text(_COLUMN * 1.4, y, "moves at any time", va="center", color=FAINT)
            for other, position in clause.items():
                face = INK if position else "white"
                axes.add_patch(Circle((columns[other], y), 0.07, facecolor=face, edgecolor=INK, linewidth=0.9))
            y -= _ROW
    axes.set_title(
        "what each joint needs before it moves\n(filled: open; hollow: closed; blue: the target)", loc="left"
    )


def _draw_panel(axes: Axes, box: Lockbox) -> None:
    """Sliders in their slots and knobs, where they are at the start; dashed: where a joint goes when it moves."""
    wide, high = axes.get_xlim()[1], axes.get_ylim()[1]
    _rounded(axes, (0.03, 0.03), (wide - 0.06, high - 0.06), 0.1, facecolor="#f4f4f2", edgecolor=FAINT)
    for joint, open_, (x, y) in zip(box.joints, box.initial, _spots(box), strict=True):
        at = (_EDGE + x * (wide - 2 * _EDGE), _EDGE + 0.18 + y * (high - 2 * _EDGE - 0.18))
        colour = TARGET if joint.name == box.target else INK
        (_slider if joint.kind == "prismatic" else _knob)(axes, at, open_=open_, colour=colour)
        _name_joint(axes, box, joint.name, (at[0], at[1] - 0.24), ha="center", va="top")
    axes.set_title(settable(box.name) + ": the panel at the start", loc="left")


def _spots(box: Lockbox) -> list[Point]:
    """The joints' places, or a row where these would lie on each other."""
    spots = [joint.place for joint in box.joints]
    if any(hypot(a[0] - b[0], a[1] - b[1]) < _CLOSE for a, b in combinations(spots, 2)):
        return [((i + 0.5) / len(spots), 0.5) for i in range(len(spots))]
    return spots


def _panel_size(box: Lockbox) -> tuple[float, float]:
    """Large enough for the names of joints beside and above each other, as far as there is room."""
    pairs = [(abs(a[0] - b[0]), abs(a[1] - b[1])) for a, b in combinations(_spots(box), 2)]
    beside = min((x for x, y in pairs if y < 0.3), default=1.0)
    above = min((y for x, y in pairs if x < 0.2 and y > 0.05), default=10.0)
    width = min(_WIDTHS[1], max(_WIDTHS[0], _NAME[0] / max(beside, 0.01) + 2 * _EDGE))
    return width, min(_HEIGHTS[1], max(_HEIGHTS[0], _NAME[1] / above + 2 * _EDGE + 0.18))


def _slider(axes: Axes, at: Point, *, open_: bool, colour: str) -> None:
    """A block in a slot: closed on the left, open on the right."""
    long, thick = 0.56, 0.17
    _rounded(axes, (at[0] - long / 2, at[1] - thick / 2), (long, thick), 0.03, facecolor="white", edgecolor=FAINT)
    for position in (not open_, open_):
        here = position == open_
        corner = (at[0] + (0.03 if position else 0.03 - long / 2), at[1] - thick / 2 - 0.025)
        block = {"facecolor": colour if here else "none", "edgecolor": colour, "linestyle": "-" if here else _GHOST}
        _rounded(axes, corner, (long / 2 - 0.06, thick + 0.05), 0.03, **block)


def _knob(axes: Axes, at: Point, *, open_: bool, colour: str) -> None:
    """A lever on a disc: closed upwards, open to the right."""
    axes.add_patch(Circle(at, 0.17, facecolor="white", edgecolor=FAINT, linewidth=0.8))
    for position in (not open_, open_):
        angle, here = 0.0 if position else pi / 2, position == open_
        x, y = [at[0], at[0] + 0.27 * cos(angle)], [at[1], at[1] + 0.27 * sin(angle)]
        lever: dict[str, Any] = {"linewidth": 5.8 if here else 0.9, "linestyle": "-" if here else _GHOST}
        axes.plot(x, y, color=colour, solid_capstyle="round", **lever)
    axes.add_patch(Circle(at, 0.05, facecolor=colour, edgecolor="white", linewidth=0.8, zorder=4))


def _rounded(axes: Axes, corner: Point, size: Point, radius: float, **settings: Any) -> None:
    """A rectangle with round corners."""
    style = f"round,pad=0,rounding_size={radius}"
    axes.add_patch(FancyBboxPatch(corner, *size, boxstyle=style, **{"linewidth": 0.8, **settings}))


def _name_joint(axes: Axes, box: Lockbox, name: str, at: Point, *, va: str = "center", ha: str) -> None:
    """The name of a joint in at most two lines, broken at the hyphen nearest to its middle; the target's is bold."""
    cuts = [i + 1 for i, c in enumerate(name) if c in "-_"] if len(name) > _LONGEST - 1 else []
    cut = min(cuts, key=lambda i: abs(i - len(name) / 2), default=0)
    lines = [name[:cut], name[cut:]] if cut else [name]
    said = "\n".join(settable(line if len(line) <= _LONGEST else line[: _LONGEST - 1] + "…") for line in lines)
    look: dict[str, Any] = {"color": TARGET, "fontweight": "bold"} if name == box.target else {}
    axes.text(*at, said, ha=ha, va=va, linespacing=1.0, **look)
