"""The interlock of a box as a wiring diagram: joints in columns by depth, one line for each alternative.

A wire leaves each joint at the height of its box. Each alternative of a joint is an upright line in the gutter on the
left of the joint's column, with an arrow to the joint. A mark where a wire meets the line says which position of that
joint the alternative needs. Rows and gutters are shared only where lines stay apart, so no line crosses a name.

Units are inches. Nothing depends on colour: the target is also bold with a thick edge; marks are filled or hollow.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, groupby
from statistics import fmean
from typing import Any

from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, FancyArrowPatch, FancyBboxPatch

from lockprobe.boxes.box import Clause, Lockbox
from lockprobe.boxes.solve import depths
from lockprobe.report.figures.frame import settable
from lockprobe.report.figures.palette import TARGET
from lockprobe.report.figures.settings import INK

Point = tuple[float, float]

_WIDE, _HIGH, _ROW = 0.87, 0.44, 0.58
"""Width and height of a joint's box; distance of rows."""

_LANE, _BEFORE, _AFTER, _MARGIN = 0.15, 0.16, 0.28, 0.08
"""Distance of lines in a gutter; room before the first and after the last; margin of the drawing."""

_SPREAD, _BACK = 0.12, -0.165
"""Largest height above its middle at which arrows meet a box; height at which a wire leaves it to the left."""

_MARK, _OPEN = 0.05, "#d4d4d4"
"""Radius of a mark, and the colour of a joint that is open at the start."""

_LONGEST = 10
"""Characters in a line of a name."""


@dataclass(frozen=True, slots=True)
class Alternative:
    """One clause of a joint.

    Attributes:
        joint: The joint that it frees.
        x: Where its line stands.
        arrow: The height at which its arrow meets the joint.
        needs: Joint -> the position that it needs, and the height at which that joint's wire meets the line.
    """

    joint: str
    x: float
    arrow: float
    needs: Mapping[str, tuple[bool, float]]


@dataclass(frozen=True, slots=True)
class Diagram:
    """The layout. The middle of each joint's box by name, the alternatives, and the size of the whole."""

    joints: Mapping[str, Point]
    alternatives: tuple[Alternative, ...]
    size: Point

    def wires(self) -> Iterator[tuple[Point, Point]]:
        """From each joint to the furthest line that its wire meets, to the right and to the left."""
        for name, (x, y) in self.joints.items():
            met = [line.x for line in self.alternatives if name in line.needs]
            if max(met, default=x) > x:
                yield (x + _WIDE / 2, y), (max(met), y)
            if min(met, default=x) < x:
                yield (x - _WIDE / 2, y + _BACK), (min(met), y + _BACK)


def diagram_of(box: Lockbox) -> Diagram:
    """The diagram of a box's interlock."""
    found = depths(box)
    last = 1 + max((depth for depth in found.values() if depth is not None), default=0)
    columns = {name: depth or last for name, depth in found.items()}
    clauses = [(name, clause) for name in box.names for clause in box.alternatives(name)]
    rows = _rows(columns, clauses)
    lanes = _lanes(columns, clauses, rows)
    left, gutters, x = {}, {}, _MARGIN
    for column in range(1, max(columns.values()) + 1):
        lines = sum(columns[name] == column for name, _ in clauses)
        gutters[column] = x + _BEFORE
        left[column] = x + (_BEFORE + _LANE * (lines - 1) + _AFTER if lines else 0.0)
        x = left[column] + _WIDE
    high = _ROW * max(rows.values()) + _HIGH + 2 * _MARGIN
    joints = {n: (left[columns[n]] + _WIDE / 2, high - _MARGIN - _HIGH / 2 - _ROW * rows[n]) for n in box.names}
    alternatives: list[Alternative] = []
    for name in box.names:
        own = [i for i, (joint, _) in enumerate(clauses) if joint == name]
        for i, arrow in zip(_by_arrival(own, clauses, rows, lanes), _heights(len(own)), strict=True):
            at, needs = gutters[columns[name]] + _LANE * lanes[i], {}
            for other, position in clauses[i][1].items():
                needs[other] = (position, joints[other][1] + (_BACK if joints[other][0] > at else 0.0))
            alternatives.append(Alternative(name, at, joints[name][1] + arrow, needs))
    return Diagram(joints=joints, alternatives=tuple(alternatives), size=(x + _MARGIN, high))


def _rows(columns: Mapping[str, int], clauses: Sequence[tuple[str, Clause]]) -> dict[str, int]:
    """The row of each joint, near those that it needs; then rows change places while that shortens the lines."""
    rows: dict[str, int] = {}
    for name in sorted(columns, key=columns.__getitem__):
        near = [rows[o] for joint, clause in clauses for o in clause if joint == name and o in rows]
        wanted = fmean(near) if near else max(rows.values(), default=-1) + 1
        tried = sorted(range(-1 - len(rows), 2 + 2 * len(rows)), key=lambda row: (abs(row - wanted), row))
        rows[name] = next(r for r in tried if all(_apart(name, o, columns, clauses) for o in rows if rows[o] == r))
    used = sorted(set(rows.values()))
    rows = {name: used.index(row) for name, row in rows.items()}
    while True:
        pairs = [{a: b, b: a} for a, b in combinations(range(len(used)), 2)]
        swapped = [{name: pair.get(row, row) for name, row in rows.items()} for pair in pairs]
        best = min(swapped, key=lambda tried: _length(tried, clauses), default=rows)
        if _length(best, clauses) >= _length(rows, clauses):
            return rows
        rows = best


def _length(rows: Mapping[str, int], clauses: Sequence[tuple[str, Clause]]) -> int:
    """The length of all lines in rows."""
    return sum(abs(rows[name] - rows[other]) for name, clause in clauses for other in clause)


def _apart(one: str, other: str, columns: Mapping[str, int], clauses: Sequence[tuple[str, Clause]]) -> bool:
    """Whether two joints and their wires have room in one row: a chain may go straight on."""
    if columns[one] < columns[other]:
        one, other = other, one
    fed = {joint for joint, clause in clauses if other in clause and columns[joint] == columns[one]}
    alternatives = sum(joint == one for joint, _ in clauses)
    start, _ = _span(one, columns, clauses)
    _, end = _span(other, columns, clauses)
    return end < start or (end == start and fed == {one} and alternatives == 1)


def _span(name: str, columns: Mapping[str, int], clauses: Sequence[tuple[str, Clause]]) -> tuple[int, int]:
    """From the first to the last gutter or box that a joint and its wires take up; gutters are even, boxes odd."""
    gutters = [2 * columns[joint] for joint, clause in clauses if name in clause or name == joint]
    return min([2 * columns[name] + 1, *gutters]), max([2 * columns[name] + 1, *gutters])


def _lanes(
    columns: Mapping[str, int], clauses: Sequence[tuple[str, Clause]], rows: Mapping[str, int]
) -> dict[int, int]:
    """For each clause the number of its line in its gutter, from the left: long lines first."""
    lengths = [max(abs(rows[name] - rows[other]) for other in clause) for name, clause in clauses]
    order = sorted(range(len(clauses)), key=lambda i: (columns[clauses[i][0]], -lengths[i], i))
    groups = groupby(order, key=lambda i: columns[clauses[i][0]])
    return {i: lane for _, group in groups for lane, i in enumerate(group)}


def _by_arrival(
    own: Iterable[int], clauses: Sequence[tuple[str, Clause]], rows: Mapping[str, int], lanes: Mapping[int, int]
) -> list[int]:
    """Clauses of one joint from the uppermost arrow to the lowest, such that none crosses another's line."""

    def key(i: int) -> tuple[bool, int]:
        name, clause = clauses[i]
        below = fmean(rows[other] for other in clause) > rows[name]
        return below, lanes[i] if below else -lanes[i]

    return sorted(own, key=key)


def _heights(count: int) -> list[float]:
    """Heights above the middle of a box at which so many arrows meet it, the uppermost first."""
    step = min(2 * _SPREAD / max(count - 1, 1), 0.1)
    return [step * ((count - 1) / 2 - k) for k in range(count)]


def draw_interlock(axes: Axes, box: Lockbox) -> None:
    """Draw which positions each joint needs before it moves. Joints that are free at the start stand on the left."""
    diagram = diagram_of(box)
    line: dict[str, Any] = {"color": INK, "linewidth": 0.9}
    head: dict[str, Any] = {"arrowstyle": "-|>,head_length=3.6,head_width=1.8", "shrinkA": 0, "shrinkB": 0}
    for start, end in diagram.wires():
        axes.plot(*zip(start, end, strict=True), zorder=1, **line)
    for one in diagram.alternatives:
        heights = [one.arrow, *(height for _, height in one.needs.values())]
        axes.plot([one.x] * 2, [min(heights), max(heights)], zorder=1, **line)
        edge = diagram.joints[one.joint][0] - _WIDE / 2
        axes.add_patch(FancyArrowPatch((one.x, one.arrow), (edge, one.arrow), zorder=2, **head, **line))
        for position, height in one.needs.values():
            face = INK if position else "white"
            axes.add_patch(Circle((one.x, height), _MARK, facecolor=face, edgecolor=INK, linewidth=0.9, zorder=4))
    for (name, (x, y)), open_ in zip(diagram.joints.items(), box.initial, strict=True):
        look = {"edgecolor": TARGET, "linewidth": 1.8} if name == box.target else {"edgecolor": INK}
        corner = (x - _WIDE / 2, y - _HIGH / 2)
        rounded(axes, corner, (_WIDE, _HIGH), 0.07, facecolor=_OPEN if open_ else "white", zorder=3, **look)
        name_joint(axes, box, name, (x, y), va="center", zorder=5)
    axes.set_title("interlock: each arrow points to the joint that it frees", loc="left")


def rounded(axes: Axes, corner: Point, size: Point, radius: float, **settings: Any) -> None:
    """A rectangle with round corners."""
    style = f"round,pad=0,rounding_size={radius}"
    axes.add_patch(FancyBboxPatch(corner, *size, boxstyle=style, **{"linewidth": 0.8, **settings}))


def name_joint(axes: Axes, box: Lockbox, name: str, at: Point, **settings: Any) -> None:
    """The short name of a joint; that of the target is bold as well."""
    look: dict[str, Any] = {"color": TARGET, "fontweight": "bold"} if name == box.target else {}
    axes.text(at[0], at[1], short_name(name), ha="center", linespacing=1.0, **look, **settings)


def short_name(name: str) -> str:
    """A name in at most two lines, broken at the hyphen nearest to its middle, each line shortened where it is long."""
    cuts = [i + 1 for i, c in enumerate(name) if c in "-_"] if len(name) > _LONGEST - 1 else []
    cut = min(cuts, key=lambda i: abs(i - len(name) / 2), default=0)
    lines = [name[:cut], name[cut:]] if cut else [name]
    return "\n".join(settable(line if len(line) <= _LONGEST else line[: _LONGEST - 1] + "…") for line in lines)


def symbols(box: Lockbox) -> dict[str, Line2D]:
    """The legend: what the marks mean that the diagram of this box has."""
    alternatives = [box.alternatives(name) for name in box.names]
    clauses = [clause for several in alternatives for clause in several]
    positions = [position for clause in clauses for position in clause.values()]
    marks = {
        "target": _mark("white", marker="s", color="white", markeredgecolor=TARGET),
        "the joint before it must be open": _mark(INK) if any(positions) else None,
        "the joint before it must be closed": _mark("white") if not all(positions) else None,
        "on one line: all are required": _mark(INK, linestyle="-") if max(map(len, clauses), default=0) > 1 else None,
        "several arrows: any one suffices": _mark(INK, marker=">") if max(map(len, alternatives)) > 1 else None,
        "open at the start": _mark(_OPEN, marker="s", color=_OPEN) if any(box.initial) else None,
    }
    return {name: mark for name, mark in marks.items() if mark}


def _mark(face: str, **settings: Any) -> Line2D:
    look: dict[str, Any] = {"color": INK, "linestyle": "none", "linewidth": 0.9, "marker": "o", "markersize": 5}
    return Line2D([], [], markerfacecolor=face, **look | settings)
