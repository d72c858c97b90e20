"""Positions of joints on the panel: six layouts, and random reassignment of joints to positions.

Baum et al. (IROS 2017) have ``serial``, a row along the interlock; ``zigzag``, the same on two rows; ``ngram``, the
corners of a polygon in the order of its star, so that joints that lock each other lie across; and ``misleading``
(``lockbox_test_evil``), a row on which joints that lock each other lie as far apart as possible, for agents that expect
the cause of a lock nearby. ``grid`` fills rows of a square; places of ``scattered`` are drawn.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from math import ceil, comb, cos, gcd, pi, sin, sqrt
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.box import JointKind, Lockbox
from lockprobe.boxes.solve import orders

LayoutName = Literal["serial", "zigzag", "ngram", "grid", "scattered", "misleading"]

Place = tuple[float, float]

_KINDS: tuple[JointKind, ...] = ("prismatic", "revolute")
_WORDS = {"prismatic": "slider", "revolute": "knob"}
_COLUMNS, _ROWS, _JITTER = 4, 3, 0.04
"""Columns and rows of cells for scattered joints, one joint per cell, and the largest distance from a cell's middle."""

_DRAWS = 1000
"""Orders that are drawn at most before the best of them is taken."""


def places(layout: LayoutName, count: int, rng: np.random.Generator) -> tuple[Place, ...]:
    """The places of a layout, from the left and from below, [0, 1], for joints in the order of the interlock.

    ``misleading`` has the places of ``serial``; only ``scattered`` draws from ``rng``.
    """
    if layout == "zigzag":
        found = [((i + 0.5) / count, 0.3 if i % 2 else 0.7) for i in range(count)]
    elif layout == "ngram":
        # corners in the order of the widest star polygon; for 4 and 6, which have none, pairs of opposite corners
        step = max((k for k in range(2, (count + 1) // 2) if gcd(count, k) == 1), default=max(1, count // 2))
        rounds = gcd(count, step)
        star = [(first + k * step) % count for first in range(rounds) for k in range(count // rounds)]
        found = [(0.5 + 0.4 * sin(2 * pi * i / count), 0.5 + 0.4 * cos(2 * pi * i / count)) for i in star]
    elif layout == "grid":
        columns = ceil(sqrt(count))
        rows = ceil(count / columns)
        found = [((i % columns + 0.5) / columns, 1 - (i // columns + 0.5) / rows) for i in range(count)]
    elif layout == "scattered":
        cells = _shuffled(_COLUMNS * _ROWS, rng)[:count]
        shifts = _JITTER * (2 * rng.random((count, 2)) - 1)
        middles = np.column_stack([(cells % _COLUMNS + 0.5) / _COLUMNS, (cells // _COLUMNS + 0.5) / _ROWS])
        found = [(float(x), float(y)) for x, y in middles + shifts]
    else:
        found = [((i + 0.5) / count, 0.5) for i in range(count)]
    return tuple((round(x, 3), round(y, 3)) for x, y in found)


def _shuffled(count: int, rng: np.random.Generator) -> NDArray[np.int64]:
    """A random permutation from uniform numbers, whose stream is the same in every release of NumPy."""
    return np.argsort(rng.random(count), kind="stable")


def laid_out(box: Lockbox, layout: LayoutName, rng: np.random.Generator, *, dealt: bool = False) -> Lockbox:
    """The same interlock with another layout, which follows the order of the joints.

    The joints are then in panel order: from the left, and from above if two are equally far left. If they are ``dealt``
    places and kinds are assigned at random, and joints are named after kind and place (``slider-1`` is leftmost), so
    that panel and names do not reveal the interlock.
    """
    spots = places(layout, len(box.joints), rng)
    order: Sequence[int] = range(len(spots))
    if layout == "misleading":  # a random order among those with the largest total distance of locking pairs
        far, deals = _distances(spots), orders(len(spots))
        apart = sum((far[deals[:, i], deals[:, j]] for i, j in sorted(locking_pairs(box))), np.zeros(len(deals)))
        best = np.flatnonzero(apart > apart.max() - 1e-6)
        order = deals[best[int(rng.random() * len(best))]].tolist()
    elif dealt:
        order = _shuffled(len(spots), rng).tolist()
    joints = [replace(joint, place=spots[at]) for joint, at in zip(box.joints, order, strict=True)]
    if dealt:
        joints = [replace(joint, kind=_KINDS[int(rng.random() < 0.5)]) for joint in joints]
    panel = sorted(range(len(joints)), key=lambda i: (joints[i].place[0], -joints[i].place[1]))
    found = permuted(replace(box, joints=tuple(joints)), panel)
    if not dealt:
        return found
    names = {joint.name: f"{_WORDS[joint.kind]}-{i}" for i, joint in enumerate(found.joints, 1)}
    return replace(
        found,
        joints=tuple(replace(joint, name=names[joint.name]) for joint in found.joints),
        interlock={
            names[joint]: tuple({names[other]: position for other, position in clause.items()} for clause in clauses)
            for joint, clauses in found.interlock.items()
        },
        target=names[found.target],
    )


def permuted(box: Lockbox, order: Sequence[int]) -> Lockbox:
    """The same box with its joints listed in another order, each with its place and its start."""
    return replace(box, joints=tuple(box.joints[i] for i in order), initial=tuple(box.initial[i] for i in order))


def redealt(box: Lockbox, rng: np.random.Generator, *, neutral: bool = False) -> Lockbox:
    """The same joints and interlock with the joints assigned to the same places in a random order.

    This is "same interlock, new layout every round", the protocol of the human studies (Zenkri, Bolenz, Pachur and
    Brock, Adaptive Behavior 2025). Joints and initial configuration are in the new panel order. A single panel that is
    to give nothing away is drawn ``neutral``: see :func:`neutral_order`.
    """
    near = neighbours(box) if neutral else set()  # without any, every order is as good
    dealt = permuted(box, neutral_order(locking_pairs(box), near, len(box.joints), rng))
    places = zip(dealt.joints, box.joints, strict=True)
    return replace(dealt, joints=tuple(replace(joint, place=there.place) for joint, there in places))


def neutral_order(
    locking: Collection[tuple[int, int]], near: Collection[tuple[int, int]], count: int, rng: np.random.Generator
) -> list[int]:
    """A random order in which about as many locking pairs are neighbours as on average over all orders.

    Where one order is drawn for many trials, a plainly random one could follow the interlock, as one in twelve does for
    four joints that lock each other in a row, and then it would in all of them.

    ``locking`` are pairs of joints that lock each other, ascending; ``near`` are pairs of positions that are
    neighbours. The order has a joint for each of so many positions.
    """
    usual = len(locking) * len(near) / max(1, comb(count, 2))
    best, off = list[int](), float("inf")
    for _ in range(_DRAWS):
        order = _shuffled(count, rng).tolist()
        met = sum((min(order[i], order[j]), max(order[i], order[j])) in locking for i, j in near)
        if abs(met - usual) < off:
            best, off = order, abs(met - usual)
        if off < 1:
            break
    return best


def locking_pairs(box: Lockbox) -> set[tuple[int, int]]:
    """Pairs of joints (indices in panel order, ascending) in which one is part of the other's interlock."""
    index = {name: i for i, name in enumerate(box.names)}
    named = ((index[j], index[o]) for j in box.names for clause in box.alternatives(j) for o in clause)
    return {(min(pair), max(pair)) for pair in named}


def neighbours(box: Lockbox) -> set[tuple[int, int]]:
    """Pairs of joints (indices in panel order, ascending) in which one is a nearest neighbour of the other."""
    far = _distances([joint.place for joint in box.joints])
    np.fill_diagonal(far, np.inf)
    near = far < far.min(axis=1, keepdims=True) + 1e-6
    return {(int(min(pair)), int(max(pair))) for pair in np.argwhere(near)}


def _distances(spots: Sequence[Place]) -> NDArray[np.float64]:
    here = np.array(spots)
    return np.asarray(np.hypot(*(here[:, None] - here[None]).transpose(2, 0, 1)))
