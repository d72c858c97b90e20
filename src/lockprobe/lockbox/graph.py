"""The interlock as a drawing in layers: where joints, the dots that join positions, and lines go. No ink yet.

Joints stand in columns by depth (:func:`lockprobe.lockbox.difficulty.depths`), what is free at the start on the left.
Before each joint, in a column of its own, stands an entry for each alternative; lines run from the joints that it names
to there, with a bend in every column that they cross. Orders within columns cross few lines, heights keep them straight
(Sugiyama, Tagawa and Toda, IEEE Transactions on Systems, Man, and Cybernetics 11, 1981).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from statistics import fmean
from typing import Literal

import numpy as np

from lockprobe.lockbox.box import Lockbox
from lockprobe.lockbox.difficulty import depths

__all__ = ["Graph", "Line", "Node", "graph_of"]

NodeKind = Literal["joint", "all", "bend"]

_HALF: Mapping[NodeKind, float] = {"joint": 0.27, "all": 0.15, "bend": 0.09}
"""Half the height that a node needs, in inches."""

_PULL: Mapping[NodeKind, float] = {"joint": 1.0, "all": 2.0, "bend": 6.0}
"""How strongly a line between two nodes wants to be straight; the weights of both are multiplied."""

_ROUNDS, _STARTS, _SWEEPS, _CANDIDATES = 16, 12, 6, 12
"""Times that heights are drawn together; starts and sweeps in search of an order; orders that are tried out."""

Order = tuple[tuple[int, ...], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Node:
    """A place in the drawing.

    Attributes:
        kind: A ``joint``; a dot where ``all`` positions of an alternative meet; a ``bend`` of a line.
        name: The joint's name; empty for others.
        column: From the left: even for joints, odd between them.
        height: In inches; the drawing's middle is 0.
    """

    kind: NodeKind
    name: str
    column: int
    height: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """A line of the drawing.

    Attributes:
        nodes: Indices of the nodes that it runs through, from a joint or dot.
        arrow: Whether it ends at the joint that it frees.
        closed: Whether the joint where it starts has to be closed.
    """

    nodes: tuple[int, ...]
    arrow: bool
    closed: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Graph:
    """The drawing. Several arrows into one joint are alternatives: any of them is enough."""

    nodes: tuple[Node, ...]
    lines: tuple[Line, ...]


class _Sheet:
    """Nodes and lines while they are being placed."""

    def __init__(self) -> None:
        self.kinds: list[tuple[NodeKind, str, int]] = []
        self.lines: list[Line] = []
        self.landings: dict[int, int] = {}

    def add(self, kind: NodeKind, name: str, column: int) -> int:
        self.kinds.append((kind, name, column))
        return len(self.kinds) - 1

    def bends(self, columns: Iterable[int]) -> tuple[int, ...]:
        return tuple(self.add("bend", "", column) for column in columns)

    def landing(self, joint: int) -> int:
        """A bend right above or below a joint."""
        bend = self.add("bend", "", self.kinds[joint][2])
        self.landings[bend] = joint
        return bend

    def line(self, nodes: tuple[int, ...], *, arrow: bool, closed: bool) -> None:
        self.lines.append(Line(nodes=nodes, arrow=arrow, closed=closed))


def graph_of(box: Lockbox) -> Graph:
    """The drawing of a box's interlock."""
    sheet = _Sheet()
    layers = depths(box)
    last = 1 + max((layer for layer in layers.values() if layer is not None), default=0)
    joints = {name: sheet.add("joint", name, 2 * (layer or last)) for name, layer in layers.items()}
    for name, head in joints.items():
        for clause in box.alternatives(name):
            if len(clause) == 1:
                _single(sheet, joints[next(iter(clause))], head, closed=not next(iter(clause.values())))
            else:
                _several(sheet, {joints[other]: position for other, position in clause.items()}, head)
    heights = _heights(sheet)
    return Graph(
        nodes=tuple(
            Node(kind=kind, name=name, column=column, height=height)
            for (kind, name, column), height in zip(sheet.kinds, heights, strict=True)
        ),
        lines=tuple(sheet.lines),
    )


def _single(sheet: _Sheet, source: int, head: int, *, closed: bool) -> None:
    """A line from one joint to another; one that runs to the left leaves and arrives from above or below."""
    here, there = sheet.kinds[source][2], sheet.kinds[head][2]
    bends: tuple[int, ...] = ()
    if here > there:
        bends = (sheet.landing(source), *sheet.bends(range(here - 1, there, -1)), sheet.landing(head))
    elif here < there - 2:
        bends = sheet.bends(range(here + 1, there))
    sheet.line((source, *bends, head), arrow=True, closed=closed)


def _several(sheet: _Sheet, needs: Mapping[int, bool], head: int) -> None:
    """Lines from several joints to a dot, and one from there to the joint that they free."""
    dot = sheet.add("all", "", sheet.kinds[head][2] - 1)
    for source, position in needs.items():
        here, there = sheet.kinds[source][2], sheet.kinds[dot][2]
        if here < there:
            bends = sheet.bends(range(here + 1, there))
        else:
            bends = (sheet.landing(source), *sheet.bends(range(here - 1, there, -1)))
        sheet.line((source, *bends, dot), arrow=False, closed=not position)
    sheet.line((dot, head), arrow=True, closed=False)


def _heights(sheet: _Sheet) -> list[float]:
    """The height of each node: of the orders with the fewest crossings that were met, the one of the straightest lines.

    A line within a column counts for neither.
    """
    columns: dict[int, list[int]] = {}
    for i, (_, _, column) in enumerate(sheet.kinds):
        columns.setdefault(column, []).append(i)
    links = [pair for line in sheet.lines for pair in pairwise(line.nodes)]
    met = _met(sheet, columns, links)
    fewest = min(met.values())
    placed = [_placed(sheet, order, links) for order in [o for o, n in met.items() if n == fewest][:_CANDIDATES]]
    place = min(placed, key=lambda at: sum(abs(at[a] - at[b]) for a, b in links))
    middle = (max(place.values()) + min(place.values())) / 2
    return [place[i] - middle for i in range(len(sheet.kinds))]


def _placed(sheet: _Sheet, order: Order, links: Sequence[tuple[int, int]]) -> dict[int, float]:
    """Heights for an order: each node drawn to its neighbours, column after column."""
    place = {node: 0.0 for row in order for node in row}
    for row in order:
        place |= _apart(sheet, row, [0.0] * len(row), [1.0] * len(row))
    near = _neighbours(links)
    for sweep in range(_ROUNDS):
        for row in order if sweep % 2 else order[::-1]:
            wanted, weights = zip(*(_wanted(sheet, node, near.get(node, ()), place) for node in row), strict=True)
            place |= _apart(sheet, row, wanted, weights)
    return place


def _wanted(sheet: _Sheet, node: int, others: Sequence[int], place: Mapping[int, float]) -> tuple[float, float]:
    """The height that keeps a node's lines straight, and how much that matters."""
    pulls = [_PULL[sheet.kinds[node][0]] * _PULL[sheet.kinds[other][0]] for other in others]
    if not pulls:
        return place[node], 0.1
    return sum(pull * place[other] for pull, other in zip(pulls, others, strict=True)) / sum(pulls), sum(pulls)


def _apart(sheet: _Sheet, order: Sequence[int], wanted: Sequence[float], weights: Sequence[float]) -> dict[int, float]:
    """The heights nearest to those wanted that keep the order and leave every node its room."""
    from scipy.optimize import isotonic_regression

    halves = [_HALF[sheet.kinds[node][0]] for node in order]
    room = np.cumsum([0.0, *(a + b for a, b in pairwise(halves))])
    fitted = isotonic_regression(np.array(wanted) - room, weights=weights).x
    return dict(zip(order, (fitted + room).tolist(), strict=True))


def _neighbours(links: Sequence[tuple[int, int]]) -> dict[int, list[int]]:
    near: dict[int, list[int]] = {}
    for a, b in links:
        near.setdefault(a, []).append(b)
        near.setdefault(b, []).append(a)
    return near


def _met(sheet: _Sheet, columns: Mapping[int, list[int]], links: Sequence[tuple[int, int]]) -> dict[Order, int]:
    """Orders of all columns with their crossings: each node to the mean place of its neighbours, again and again.

    Starts are shuffled, always in the same way. A bend above or below its joint stays next to it.
    """
    near = _neighbours(links)
    rng = np.random.default_rng(0)
    found: dict[Order, int] = {}
    for start in range(_STARTS):
        order = [list(columns[column]) for column in sorted(columns)]
        if start:
            order = [[row[i] for i in rng.permutation(len(row))] for row in order]
        for sweep in range(_SWEEPS):
            for at in range(len(order)) if sweep % 2 else range(len(order) - 1, -1, -1):
                rank = {node: i - len(row) / 2 for row in order for i, node in enumerate(row)}
                order[at] = _sorted(sheet, order[at], rank, near)
            frozen = tuple(map(tuple, order))
            found[frozen] = _crossings(frozen, links)
    return found


def _sorted(
    sheet: _Sheet, row: Sequence[int], rank: Mapping[int, float], near: Mapping[int, Sequence[int]]
) -> list[int]:
    mean = {node: fmean(rank[other] for other in near.get(node, [node])) for node in row}
    homes = {node: sheet.landings.get(node, node) for node in row}
    return sorted(row, key=lambda node: (mean[homes[node]], homes[node], mean[node] - mean[homes[node]]))


def _crossings(order: Order, links: Sequence[tuple[int, int]]) -> int:
    """How many pairs of lines between the same two columns change sides."""
    rank = {node: i for row in order for i, node in enumerate(row)}
    at = {node: i for i, row in enumerate(order) for node in row}
    gaps: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for a, b in links:
        left, right = sorted((a, b), key=at.__getitem__)
        gaps.setdefault((at[left], at[right]), []).append((rank[left], rank[right]))
    return sum(
        (a[0] - b[0]) * (a[1] - b[1]) < 0
        for pairs in gaps.values()
        for i, a in enumerate(pairs)
        for b in pairs[i + 1 :]
    )
