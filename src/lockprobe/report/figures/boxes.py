"""A box as a picture: the panel at the start, and below it what each joint needs, which no agent sees. In inches."""

from __future__ import annotations

from math import cos, pi, sin
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyBboxPatch

from lockprobe.boxes.box import Joint, Lockbox
from lockprobe.report.figures import own_settings
from lockprobe.report.figures.drawing import FAINT, INK, TARGET, settable

Point = tuple[float, float]

_EDGE = 0.46
"""How far joints stay from the edge of the panel."""

_COLUMN, _ROW = 0.87, 0.36
"""Width of a column and height of a row of the table of needs; a joint with its name has as much room."""

_HEAD, _GAP = 0.4, 0.1
"""Height of a heading; below the panel and the table."""

_LONGEST = 10
"""Characters in a line of a name."""

_GHOST = (0, (2, 1.5))
"""How a joint is drawn where it goes when it moves."""


@own_settings()
def box_figure(box: Lockbox) -> Figure:
    """The picture of a box: the panel, and below it a row for each alternative of a joint with the joints it needs."""
    rows = [(name, clause) for name in box.names for clause in box.alternatives(name) or [{}]]
    needed = [name for name in box.names if any(name in clause for _, clause in rows)]
    places = [joint.place for joint in box.joints]
    across, heights = zip(*places, strict=True)
    panel = max(3.2, _COLUMN * len({*across}) + 2 * _EDGE), 1.4 if len({*heights}) == 1 else 2.8
    table = _COLUMN * (1.3 + max(2, len(needed))), _HEAD + _ROW * len(rows)
    width, above = max(panel[0], table[0]) + 0.1, table[1] + _HEAD + 2 * _GAP
    height = above + panel[1] + _HEAD
    figure = Figure(figsize=(width, height))

    def axes(bottom: float, size: Point) -> Axes:
        made = figure.add_axes((0.05 / width, bottom / height, size[0] / width, size[1] / height))
        made.set(xlim=(0, size[0]), ylim=(0, size[1]))
        made.set_axis_off()
        return made

    _draw_panel(axes(above, panel), box, places, panel)
    _draw_needs(axes(_GAP, table), box, needed, rows)
    return figure


def _draw_needs(axes: Axes, box: Lockbox, needed: list[str], rows: list[tuple[str, Any]]) -> None:
    """Filled where a joint has to be open, hollow where it has to be closed; a row for each alternative."""
    columns = {name: _COLUMN * (1.8 + i) for i, name in enumerate(needed)}
    (_, wide), (_, y) = axes.get_xlim(), axes.get_ylim()
    for name, x in columns.items():
        _name_joint(axes, box, name, (x, y - _HEAD / 2), ha="center")
    y, before = y - _HEAD - _ROW / 2, ""
    for name, clause in rows:
        if name == before:
            axes.text(_COLUMN * 1.15, y, "or", ha="right", va="center")
        else:
            axes.plot([0, wide], [y + _ROW / 2] * 2, color=FAINT, linewidth=0.5)
            _name_joint(axes, box, name, (_COLUMN * 1.15, y), ha="right")
        if not clause:
            axes.text(_COLUMN * 1.4, y, "moves at any time", va="center", color=FAINT)
        for other, position in clause.items():
            face = INK if position else "white"
            axes.add_patch(Circle((columns[other], y), 0.07, facecolor=face, edgecolor=INK, linewidth=0.9))
        y, before = y - _ROW, name
    axes.set_title(
        "what each joint needs before it moves\n(filled: open; hollow: closed; blue: the target)", loc="left"
    )


def _draw_panel(axes: Axes, box: Lockbox, places: list[Point], size: Point) -> None:
    """Sliders in their slots and knobs, where they are at the start; dashed: where a joint goes when it moves."""
    wide, high = size
    _rounded(axes, (0.03, 0.03), (wide - 0.06, high - 0.06), 0.1, facecolor="#f4f4f2", edgecolor=FAINT)
    for joint, open_, place in zip(box.joints, box.initial, places, strict=True):
        x, y = _EDGE + place[0] * (wide - 2 * _EDGE), _EDGE + 0.18 + place[1] * (high - 2 * _EDGE - 0.18)
        _draw_joint(axes, joint, (x, y), open_=open_, colour=TARGET if joint.name == box.target else INK)
        _name_joint(axes, box, joint.name, (x, y - 0.24), ha="center", va="top")
    axes.set_title(settable(box.name) + ": the panel at the start", loc="left")


def _draw_joint(axes: Axes, joint: Joint, at: Point, *, open_: bool, colour: str) -> None:
    """A block in a slot, closed on the left and open on the right; or a lever on a disc, upwards and to the right."""
    (x, y), slides = at, joint.kind == "prismatic"
    if slides:
        _rounded(axes, (x - 0.28, y - 0.085), (0.56, 0.17), 0.03, facecolor="white", edgecolor=FAINT)
    else:
        axes.add_patch(Circle(at, 0.17, facecolor="white", edgecolor=FAINT, linewidth=0.8))
    for position in (not open_, open_):
        here, angle = position == open_, 0.0 if position else pi / 2
        style: dict[str, Any] = {"linestyle": "-" if here else _GHOST}
        if slides:
            style |= {"facecolor": colour if here else "none", "edgecolor": colour}
            _rounded(axes, (x + (0.03 if position else -0.25), y - 0.11), (0.22, 0.22), 0.03, **style)
        else:
            style |= {"linewidth": 5.8 if here else 0.9, "solid_capstyle": "round"}
            axes.plot([x, x + 0.27 * cos(angle)], [y, y + 0.27 * sin(angle)], color=colour, **style)


def _rounded(axes: Axes, corner: Point, size: Point, radius: float, **settings: Any) -> None:
    """A rectangle with round corners."""
    style = f"round,pad=0,rounding_size={radius}"
    axes.add_patch(FancyBboxPatch(corner, *size, boxstyle=style, linewidth=0.8, **settings))


def _name_joint(axes: Axes, box: Lockbox, name: str, at: Point, *, va: str = "center", ha: str) -> None:
    """The name of a joint in at most two lines, broken at the hyphen nearest to its middle; the target's is bold."""
    cuts = [i + 1 for i, c in enumerate(name) if c in "-_"] if len(name) > _LONGEST - 1 else []
    cut = min(cuts, key=lambda i: abs(i - len(name) / 2), default=0)
    lines = [name[:cut], name[cut:]] if cut else [name]
    said = "\n".join(settable(line if len(line) <= _LONGEST else line[: _LONGEST - 1] + "…") for line in lines)
    look: dict[str, Any] = {"color": TARGET, "fontweight": "bold"} if name == box.target else {}
    axes.text(*at, said, ha=ha, va=va, linespacing=1.0, **look)
