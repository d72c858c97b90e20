"""Which gates a box's interlock asks for, and the pins and blocks of each.

A joint moves if any of its clauses holds entirely. The same said otherwise (in conjunctive normal form) is a number of
gates that must all be open, each of which any of its literals opens. A gate lies in a hidden layer of its own:

* a *block* is fixed to the joint and travels with it;
* a *pin* on a hidden bolt stands in the block's way and leaves it at right angles to the way. The bolt of a gate with
  one literal is geared to the other joint; a bolt with several is sprung and is lifted by any of its *lifters*, each of
  which is geared to a joint.

The block is shorter than the joint's travel by the pin, so that the pin lies before it at one end of the travel and
behind it at the other: it can come back at both ends, never between. What joint and gate can do together is an H. The
faces that meet are parallel to the bolt's way, so that no force on the joint can drive the pin out.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from lockprobe.errors import BadValue
from lockprobe.lockbox.box import Lockbox
from lockprobe.plants.scene.fitting import Fitting

__all__ = [
    "MAX_GATES",
    "PIN_RADIUS",
    "STROKE",
    "Block",
    "Gate",
    "Literal",
    "blocks_of",
    "gates_of",
    "pin_of",
]

MAX_GATES = 40
"""Of one box: each has a layer of its own behind the board."""

PIN_RADIUS = 0.003

_PLAY = 0.001
"""Between pin and block where a locked joint rests, metres."""

_BLOCK_HALF_WIDTH = 0.008
"""Of a block across the joint's way, metres."""

STROKE = _BLOCK_HALF_WIDTH + PIN_RADIUS + 0.003
"""Of a bolt, from in the way to out of it, metres."""

_RING = 0.04
"""From a lever's pivot to the pins in its way, metres."""

_WALL = 0.008
_FILLERS = 2

Literal = tuple[int, bool]
"""A joint by place in panel order, and the position that it must have."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Gate:
    """Locks a joint unless one of its literals holds.

    Attributes:
        joint: The joint that it locks, by place in panel order.
        literals: What opens it, in panel order.
    """

    joint: int
    literals: tuple[Literal, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """A box that is part of a joint, where it is while the joint is at position 0.

    Attributes:
        middle: In the frame of the panel, metres.
        angle: Of its long side from the panel's x, radians.
        half: Half its sides, metres.
    """

    middle: tuple[float, float]
    angle: float
    half: tuple[float, float]


def gates_of(box: Lockbox) -> tuple[Gate, ...]:
    """The gates of a box: as few as say what its interlock says.

    Raises:
        BadValue: If a joint never moves, or there would be more than ``MAX_GATES``.
    """
    index = {name: i for i, name in enumerate(box.names)}
    gates: list[Gate] = []
    for joint, name in enumerate(box.names):
        clauses = box.interlock.get(name, ({},))
        if not clauses:
            raise BadValue(f"interlock of {name}", list(clauses), "a clause: without one the joint never moves")
        wanted: set[frozenset[Literal]] = {frozenset()}
        for clause in clauses:
            literals = [(index[other], position) for other, position in clause.items()]
            wanted = _necessary(known | {literal} for known in wanted for literal in literals)
            _refuse_above(box, len(wanted) - 1)
        gates += [Gate(joint=joint, literals=found) for found in sorted(tuple(sorted(gate)) for gate in wanted)]
        _refuse_above(box, len(gates))
    return tuple(gates)


def _refuse_above(box: Lockbox, gates: int) -> None:
    if gates > MAX_GATES:
        raise BadValue(f"interlock of {box.name}", f"{gates} gates or more", f"one of at most {MAX_GATES} gates")


def _necessary(gates: Iterable[frozenset[Literal]]) -> set[frozenset[Literal]]:
    """Without gates that always stand open, and without those that are open whenever another is."""
    possible = {gate for gate in gates if not any((joint, not position) in gate for joint, position in gate)}
    kept: set[frozenset[Literal]] = set()
    for gate in sorted(possible, key=len):
        if not any(other <= gate for other in kept):
            kept.add(gate)
    return kept


def pin_of(fitting: Fitting) -> tuple[tuple[float, float], tuple[float, float]]:
    """Where the pin of a gate stands while it locks, and the direction in which it leaves, in the panel's frame.

    Returns:
        Place in metres; direction of length 1, at right angles to the way of the joint there.
    """
    if fitting.kind == "prismatic":
        middle = fitting.knob(0.5)
        out = fitting.direction + math.pi / 2
        return (float(middle[0]), float(middle[1])), (math.cos(out), math.sin(out))
    out = fitting.direction
    x, y = math.cos(out), math.sin(out)
    return (fitting.origin[0] + _RING * x, fitting.origin[1] + _RING * y), (x, y)


def blocks_of(fitting: Fitting) -> tuple[Block, ...]:
    """The block of a gate: before the pin at position 0, past it at position 1."""
    return tuple(_straight(fitting) if fitting.kind == "prismatic" else _sector(fitting))


def _straight(fitting: Fitting) -> Iterator[Block]:
    (x, y), _ = pin_of(fitting)
    back = fitting.travel / 2
    along = (math.cos(fitting.direction), math.sin(fitting.direction))
    yield Block(
        middle=(x - back * along[0], y - back * along[1]),
        angle=fitting.direction,
        half=(back - PIN_RADIUS - _PLAY, _BLOCK_HALF_WIDTH),
    )


def _sector(fitting: Fitting) -> Iterator[Block]:
    """Walls at both ends, and what fills the room between them.

    A wall's face is parallel to the pin's way when they touch: it lies beside the ray through the pin, not on a ray.
    """
    play = _PLAY / _RING
    first, last = fitting.direction - play, fitting.direction - fitting.travel + play
    for ray, side in ((first, -1), (last, 1)):
        yield _beside(fitting, ray, side * (PIN_RADIUS + _WALL / 2), (_BLOCK_HALF_WIDTH, _WALL / 2))
    inset = (PIN_RADIUS + _WALL) / _RING
    low, high = last + inset, first - inset
    step = (high - low) / _FILLERS
    half = 0.5 * step * _RING
    for number in range(_FILLERS):
        ray = low + (number + 0.5) * step
        yield _beside(fitting, ray, 0.0, (_BLOCK_HALF_WIDTH - 0.001, half))


def _beside(fitting: Fitting, ray: float, offset: float, half: tuple[float, float]) -> Block:
    """A box on the ring of pins, its first side along a ray from the pivot, moved sideways (anticlockwise) from it."""
    along, across = (math.cos(ray), math.sin(ray)), (-math.sin(ray), math.cos(ray))
    return Block(
        middle=(
            fitting.origin[0] + _RING * along[0] + offset * across[0],
            fitting.origin[1] + _RING * along[1] + offset * across[1],
        ),
        angle=ray,
        half=half,
    )
