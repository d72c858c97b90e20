"""The interlock as gates that must all be open, and the geometry of each gate's pin and blocks.

A joint moves if any of its clauses holds entirely. In conjunctive normal form this is a set of gates that must all be
open; any of its literals opens a gate. Each gate has a separate hidden layer:

* a *block* is fixed to the joint and travels with it;
* a *pin* on a hidden bolt stands in the block's way and retracts at right angles to it. If a gate has one literal, its
  bolt is geared to the other joint. If it has several, its bolt is sprung, and any of its *lifters* lifts it; each
  lifter is geared to one joint.

The block is shorter than the joint's travel by the width of the pin. The pin is before the block at one end of the
travel and behind it at the other, so it can return at both ends and never in between: the configuration space of joint
and gate has the shape of an H. The contact faces are parallel to the bolt's motion, so no force on the joint can push
the pin out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from lockprobe.boxes.box import Lockbox
from lockprobe.foundation.errors import BadValue
from lockprobe_robot.box_model.mounted_joint import MountedJoint

MAX_GATES = 40
"""Most gates of one box; each takes a layer behind the board."""

PIN_RADIUS = 0.003

_PLAY = 0.001
"""Gap between pin and block while a locked joint rests, metres."""

_BLOCK_HALF_WIDTH = 0.008
"""Half the width of a block across the joint's travel, metres."""

STROKE = _BLOCK_HALF_WIDTH + PIN_RADIUS + 0.003
"""Stroke of a bolt from locking to retracted, metres."""

_RING = 0.04
"""Distance of a lever's pins from its pivot, metres."""

_WALL = 0.008
_FILLERS = 2

GateLiteral = tuple[int, bool]
"""A joint by index in panel order, and the position that it must have."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Gate:
    """A gate: it locks a joint unless one of its literals holds.

    Attributes:
        joint: The joint that it locks, by index in panel order.
        literals: The conditions, any of which opens the gate, in panel order.
    """

    joint: int
    literals: tuple[GateLiteral, ...]


GateBlock = tuple[tuple[float, float], float, tuple[float, float]]
"""A box fixed to a joint, at the joint's position 0: its middle in the frame of the panel, metres; the angle of its
first side from the panel's x axis, radians; half of its side lengths, metres."""


def gates_of(box: Lockbox) -> tuple[Gate, ...]:
    """The minimal set of gates (conjunctive normal form) that is equivalent to a box's interlock.

    Raises:
        BadValue: If there would be more than ``MAX_GATES``.
    """
    index = {name: i for i, name in enumerate(box.names)}
    gates: list[Gate] = []
    for joint, name in enumerate(box.names):
        wanted: set[frozenset[GateLiteral]] = {frozenset()}
        for clause in box.interlock.get(name, ({},)):
            literals = [(index[other], position) for other, position in clause.items()]
            both = {known | {literal} for known in wanted for literal in literals}
            # without gates that are always open, and those that are open whenever another one is
            both = {gate for gate in both if not any((other, not position) in gate for other, position in gate)}
            wanted = {gate for gate in both if not any(other < gate for other in both)}
            if (many := len(gates) + len(wanted)) > MAX_GATES:
                raise BadValue(f"interlock of {box.name}", f"{many} gates or more", f"one of at most {MAX_GATES} gates")
        gates += [Gate(joint=joint, literals=found) for found in sorted(tuple(sorted(gate)) for gate in wanted)]
    return tuple(gates)


def pin_of(mounted: MountedJoint) -> tuple[tuple[float, float], tuple[float, float]]:
    """Locked position of a gate's pin, and its direction of retraction, in the panel's frame.

    Returns:
        Position in metres; direction of length 1, at right angles to the joint's motion there.
    """
    if mounted.kind == "prismatic":
        middle = mounted.knob(0.5)
        out = mounted.direction + math.pi / 2
        return (float(middle[0]), float(middle[1])), (math.cos(out), math.sin(out))
    out = mounted.direction
    x, y = math.cos(out), math.sin(out)
    return (mounted.origin[0] + _RING * x, mounted.origin[1] + _RING * y), (x, y)


def blocks_of(mounted: MountedJoint) -> tuple[GateBlock, ...]:
    """The blocks of a gate: before the pin at position 0, past it at position 1.

    A slider has one. A lever has walls at both ends and fillers between them; a wall's face is parallel to the pin's
    motion when they touch, so it lies next to the ray through the pin.
    """
    if mounted.kind == "prismatic":
        (x, y), _ = pin_of(mounted)
        back, angle = mounted.travel / 2, mounted.direction
        middle = (x - back * math.cos(angle), y - back * math.sin(angle))
        return ((middle, angle, (back - PIN_RADIUS - _PLAY, _BLOCK_HALF_WIDTH)),)
    play, inset = _PLAY / _RING, (PIN_RADIUS + _WALL) / _RING
    first, last = mounted.direction - play, mounted.direction - mounted.travel + play
    low = last + inset
    step = (first - inset - low) / _FILLERS
    wall, filler = (_BLOCK_HALF_WIDTH, _WALL / 2), (_BLOCK_HALF_WIDTH - 0.001, 0.5 * step * _RING)
    rays = [(first, -(PIN_RADIUS + _WALL / 2), wall), (last, PIN_RADIUS + _WALL / 2, wall)]
    rays += [(low + (number + 0.5) * step, 0.0, filler) for number in range(_FILLERS)]
    x, y = mounted.origin
    return tuple(
        (
            (x + _RING * math.cos(ray) - aside * math.sin(ray), y + _RING * math.sin(ray) + aside * math.cos(ray)),
            ray,
            half,
        )
        for ray, aside, half in rays
    )
