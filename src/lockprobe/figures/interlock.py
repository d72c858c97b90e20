"""The interlock of a box: joints in layers, and what each has to wait for.

Units are inches. Nothing depends on colour: the target is also bold and has a thick edge, and what has to be closed is
dashed and ends in a hollow circle.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.font_manager import FontProperties, findfont, get_font
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, FancyArrowPatch, FancyBboxPatch
from matplotlib.path import Path

from lockprobe.figures.frame import FAINT, INK, SMALL
from lockprobe.figures.palette import ACCENT
from lockprobe.lockbox.box import Lockbox
from lockprobe.lockbox.graph import Graph, Line, graph_of

__all__ = ["draw_interlock", "extent", "settable", "short_name", "symbols"]

Point = tuple[float, float]

_WIDE, _HIGH = 0.87, 0.44
"""Width and height of a joint."""

_BEFORE, _AFTER, _PLAIN = 0.51, 0.33, 0.46
"""From joint to dot, from dot to joint, and from joint to joint where no dot is between."""

_MARGIN = 0.54
"""From the middle of the outermost joint, or a line beside it, to the edge."""

_RING, _FAN, _SLOT = 0.058, 0.17, 0.135
"""Radius of a hollow end; where lines that meet in a dot come together before it, and their distance there."""

_CORNER, _BOW = 0.26, 0.33
"""Where a line that left a joint upright is level; how far one goes aside that stays in its column."""

_DASHED = (0, (3.5, 2.0))
_LONGEST = 10
"""Characters in a line of a name."""


def extent(box: Lockbox) -> tuple[float, float]:
    """Width and height of the drawing in inches."""
    graph = graph_of(box)
    heights = [node.height for node in graph.nodes]
    return max(_columns(graph).values()) + _MARGIN, max(heights) - min(heights) + 2 * (_HIGH / 2 + 0.06)


def _columns(graph: Graph) -> dict[int, float]:
    """The middle of each column, from the left edge."""
    dots = {node.column for node in graph.nodes if node.kind == "all"}
    first, last = (pick(node.column for node in graph.nodes) for pick in (min, max))
    bow = any(graph.nodes[line.nodes[0]].column == graph.nodes[line.nodes[-1]].column == first for line in graph.lines)
    x = _MARGIN + _BOW * bow
    found = {first: x}
    for column in range(first + 1, last + 1):
        dot, half = (column if column % 2 else column - 1) in dots, _WIDE / 2
        x += half + _BEFORE if dot and column % 2 else half + _AFTER if dot else half + _PLAIN / 2
        found[column] = x
    return found


def draw_interlock(axes: Axes, box: Lockbox) -> None:
    """Who has to be where so that a joint may move; what is free at the start stands on the left."""
    graph, middle = graph_of(box), sum(axes.get_ylim()) / 2
    x = _columns(graph)
    where = [(x[node.column], middle + node.height) for node in graph.nodes]
    gates, slots, ports = _gates(graph, where), _slots(graph, where), _ports(graph, where)
    for i, line in enumerate(graph.lines):
        points = _points(graph, line, where)
        aside = ports.get((i, True), 0.0), ports.get((i, False), 0.0)
        path, end = _course(graph, line, points, gates.get(i, 0.0) if line.arrow else slots[i], aside)
        _draw_line(axes, line, path, end)
    for node, at in zip(graph.nodes, where, strict=True):
        if node.kind == "all":
            axes.add_patch(Circle(at, 0.04, facecolor=INK, zorder=4))
        elif node.kind == "joint":
            _draw_joint(axes, box, node.name, at)
    axes.set_title("its interlock: what a joint needs to move", loc="left", fontsize=SMALL, color=INK)


def _draw_joint(axes: Axes, box: Lockbox, name: str, at: Point) -> None:
    target, open_ = name == box.target, box.initial[box.names.index(name)]
    axes.add_patch(
        FancyBboxPatch(
            (at[0] - _WIDE / 2, at[1] - _HIGH / 2),
            _WIDE,
            _HIGH,
            boxstyle="round,pad=0,rounding_size=0.07",
            facecolor="#d4d4d4" if open_ else "white",
            edgecolor=ACCENT if target else INK,
            linewidth=1.8 if target else 0.8,
            zorder=3,
        )
    )
    axes.text(
        at[0],
        at[1],
        short_name(name),
        ha="center",
        va="center",
        zorder=5,
        fontsize=SMALL,
        color=ACCENT if target else INK,
        fontweight="bold" if target else "normal",
        linespacing=1.0,
    )


def short_name(name: str) -> str:
    """A name in at most two lines, broken at the hyphen nearest to its middle, each line shortened where it is long."""
    cuts = [i + 1 for i, c in enumerate(name) if c in "-_"] if len(name) > _LONGEST - 1 else []
    cut = min(cuts, key=lambda i: abs(i - len(name) / 2), default=0)
    lines = [name[:cut], name[cut:]] if cut else [name]
    return "\n".join(settable(line if len(line) <= _LONGEST else line[: _LONGEST - 1] + "…") for line in lines)


def settable(text: str) -> str:
    """The text in glyphs that exist, and never read as a formula."""
    font = get_font(findfont(FontProperties()))
    return "".join(c if c.isprintable() and font.get_char_index(ord(c)) else "?" for c in text).replace("$", r"\$")


def _side_by_side(lines: list[int], origins: dict[int, float], apart: float, most: float) -> dict[int, float]:
    """Shifts from the middle, in the order of the lines' origins."""
    step = min(apart, most / max(1, len(lines) - 1))
    ordered = sorted(lines, key=lambda i: (origins[i], i))
    return {i: (k - (len(lines) - 1) / 2) * step for k, i in enumerate(ordered)}


def _gates(graph: Graph, where: list[Point]) -> dict[int, float]:
    """How far above the middle of its joint's left edge each arrow arrives."""
    arriving: dict[int, list[int]] = {}
    for i, line in enumerate(graph.lines):
        if line.arrow and (len(line.nodes) == 2 or where[line.nodes[-2]][0] < where[line.nodes[-1]][0]):
            arriving.setdefault(line.nodes[-1], []).append(i)
    origins = {i: where[line.nodes[-2]][1] for i, line in enumerate(graph.lines)}
    return {i: shift for lines in arriving.values() for i, shift in _side_by_side(lines, origins, 0.12, 0.24).items()}


def _slots(graph: Graph, where: list[Point]) -> dict[int, float]:
    """How far above a dot the lines that meet in it come near it, on either side."""
    meeting: dict[tuple[int, bool], list[int]] = {}
    for i, line in enumerate(graph.lines):
        if not line.arrow:
            meeting.setdefault((line.nodes[-1], where[line.nodes[-2]][0] < where[line.nodes[-1]][0]), []).append(i)
    origins = {i: where[line.nodes[-2]][1] for i, line in enumerate(graph.lines)}
    return {
        i: shift
        for (dot, from_left), lines in meeting.items()
        for i, shift in _side_by_side(lines, origins, _SLOT, 1.0).items()
    }


def _ports(graph: Graph, where: list[Point]) -> dict[tuple[int, bool], float]:
    """How far aside a line leaves (True) or meets (False) a joint from above or below, where several share that edge.

    Lines that leave run to the left, those that arrive come from the right.
    """
    shared: dict[tuple[int, bool], list[tuple[bool, int]]] = {}
    for i, line in enumerate(graph.lines):
        for leaves, joint, bend in ((True, line.nodes[0], line.nodes[1]), (False, line.nodes[-1], line.nodes[-2])):
            if graph.nodes[bend].kind == "bend" and where[joint][0] == where[bend][0]:
                shared.setdefault((joint, where[bend][1] > where[joint][1]), []).append((leaves, i))
    found: dict[tuple[int, bool], float] = {}
    for users in shared.values():
        arriving = [i for leaves, i in users if not leaves]
        leaving = [i for leaves, i in users if leaves]
        places = len(arriving) + bool(leaving)
        found |= {(i, True): -0.07 * (places - 1) for i in leaving}
        found |= {(i, False): 0.14 * (k + bool(leaving)) - 0.07 * (places - 1) for k, i in enumerate(arriving)}
    return found


def _draw_line(axes: Axes, line: Line, path: Path, end: Point) -> None:
    axes.add_patch(
        FancyArrowPatch(
            path=path,
            arrowstyle="-|>,head_length=3.6,head_width=1.8" if line.arrow and not line.closed else "-",
            color=FAINT if line.closed else INK,
            linewidth=0.9,
            linestyle=_DASHED if line.closed else "-",
            zorder=2,
        )
    )
    if line.closed:
        axes.add_patch(Circle(end, _RING, facecolor="white", edgecolor=INK, linewidth=0.9, zorder=4))


def _points(graph: Graph, line: Line, where: list[Point]) -> list[Point]:
    """Where a line runs through. Past a joint it is level for the joint's whole width."""
    points = [where[line.nodes[0]]]
    for before, node, after in zip(line.nodes, line.nodes[1:], line.nodes[2:], strict=False):
        column = graph.nodes[node].column
        (x, y), ahead = where[node], np.copysign(_WIDE / 2, where[after][0] - where[before][0])
        passes = column % 2 == 0 and column not in (graph.nodes[before].column, graph.nodes[after].column)
        points += [(x - ahead, y), (x + ahead, y)] if passes else [(x, y)]
    return [*points, where[line.nodes[-1]]]


def _course(
    graph: Graph, line: Line, points: list[Point], shift: float, aside: tuple[float, float]
) -> tuple[Path, Point]:
    """The path of a line, and where its hollow end would be.

    Args:
        graph: The drawing.
        line: The line.
        points: Where it runs through.
        shift: How far above the middle of a joint's left edge, or of a dot, it arrives.
        aside: How far to the right of the middle it leaves and meets joints from above or below.
    """
    first, last = points[0], points[-1]
    if len(points) == 2 and first[0] == last[0]:
        return _beside(first, last, shift)
    leaves_upright, arrives_upright = first[0] == points[1][0], points[-2][0] == last[0]
    if graph.nodes[line.nodes[0]].kind == "joint":
        points[0] = _edge(first, points[1], aside[0]) if leaves_upright else (first[0] + _WIDE / 2, first[1])
    if not line.arrow:
        meet = (last[0] - _FAN if points[-2][0] < last[0] else last[0] + _FAN, last[1] + shift)
        path = _spline([*points[:-1], meet], leaves_upright=leaves_upright, arrives_upright=False)
        codes = np.append(np.asarray(path.codes), Path.LINETO)
        return Path(np.vstack([np.asarray(path.vertices), last]), codes), meet
    points[-1] = _edge(last, points[-2], aside[1]) if arrives_upright else (last[0] - _WIDE / 2, last[1] + shift)
    path = _spline(points, leaves_upright=leaves_upright, arrives_upright=arrives_upright)
    if arrives_upright:
        return path, (points[-1][0], points[-1][1] + (_RING if points[-1][1] > last[1] else -_RING))
    return path, (points[-1][0] - _RING, points[-1][1])


def _beside(first: Point, last: Point, shift: float) -> tuple[Path, Point]:
    """A bow on the left of a column, from one joint of it to another."""
    edge, away = first[0] - _WIDE / 2, first[0] - _WIDE / 2 - _BOW
    start, end = first[1] + np.copysign(_HIGH / 4, last[1] - first[1]), last[1] + shift
    path = Path([(edge, start), (away, start), (away, end), (edge, end)], [Path.MOVETO, *[Path.CURVE4] * 3])
    return path, (edge - _RING, end)


def _edge(joint: Point, bend: Point, aside: float) -> Point:
    """A point of a joint's upper or lower edge, whichever faces the bend."""
    return joint[0] + aside, joint[1] + (_HIGH / 2 if bend[1] > joint[1] else -_HIGH / 2)


def _spline(points: list[Point], *, leaves_upright: bool, arrives_upright: bool) -> Path:
    """A smooth path through points, level at its ends unless it leaves or meets a joint from above or below."""
    inner = points[leaves_upright : len(points) - arrives_upright]
    if leaves_upright:
        inner[0] = (inner[0][0] + np.copysign(_CORNER, inner[1][0] - inner[0][0]), inner[0][1])
    if arrives_upright:
        inner[-1] = (inner[-1][0] - np.copysign(_CORNER, inner[-1][0] - inner[-2][0]), inner[-1][1])
    slopes = [0.0, *(_slope(a, b, c) for (a, b), (_, c) in pairwise(pairwise(inner))), 0.0]
    vertices, codes = [inner[0]], [Path.MOVETO]
    if leaves_upright:
        vertices, codes = [points[0], (points[0][0], inner[0][1]), inner[0]], [Path.MOVETO, *[Path.CURVE3] * 2]
    for ((x0, y0), (x1, y1)), (m0, m1) in zip(pairwise(inner), pairwise(slopes), strict=True):
        third = 0.4 * (x1 - x0)
        vertices += [(x0 + third, y0 + m0 * third), (x1 - third, y1 - m1 * third), (x1, y1)]
        codes += [Path.CURVE4] * 3
    if arrives_upright:
        vertices += [(points[-1][0], inner[-1][1]), points[-1]]
        codes += [Path.CURVE3] * 2
    return Path(vertices, codes)


def _slope(before: Point, here: Point, after: Point) -> float:
    """The slope at a bend: level where the line turns, else between those of its sides."""
    if (here[1] - before[1]) * (after[1] - here[1]) <= 0:
        return 0.0
    return (after[1] - before[1]) / (after[0] - before[0])


def symbols(box: Lockbox) -> list[tuple[Line2D, str]]:
    """What the marks mean, of those that the drawing has."""
    alternatives = [box.alternatives(name) for name in box.names]
    clauses = [clause for several in alternatives for clause in several]
    positions = [position for clause in clauses for position in clause.values()]
    target = Line2D([], [], marker="s", color="white", markeredgecolor=ACCENT, linestyle="none", markersize=5)
    found: list[tuple[Line2D, str]] = [(target, "target")]
    if any(positions):
        found.append((_mark("-", ">", INK), "has to be open"))
    if not all(positions):
        found.append((_mark(_DASHED, "o", "white"), "has to be closed"))
    if any(len(clause) > 1 for clause in clauses):
        found.append((_mark("none", "o", INK), "joined: all together"))
    if any(len(several) > 1 for several in alternatives):
        found.append((_mark("none", ">", INK), "several arrows: any one"))
    if any(box.initial):
        found.append((Line2D([], [], marker="s", color="#d4d4d4", linestyle="none", markersize=5), "open at the start"))
    return found


def _mark(line: Literal["-", "none"] | tuple[float, Sequence[float]], marker: str, face: str) -> Line2D:
    return Line2D([], [], color=INK, linestyle=line, marker=marker, markersize=4, markerfacecolor=face, linewidth=0.9)
