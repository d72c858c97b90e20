"""What is behind the board: bolts, pins, blocks and lifters, each gate in its own layer.

Only what meets by design can touch: a pin its block, a lifter its crossbar. All of it is frictionless and firm.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import mujoco

from lockprobe.plants.layers import HIDDEN, NOTHING
from lockprobe.plants.scene.fitting import Fitting
from lockprobe.plants.scene.gates import PIN_RADIUS, STROKE, Gate, Literal, blocks_of, pin_of
from lockprobe.plants.scene.panel import Panel

__all__ = ["FIRM", "FIRM_REFERENCE", "LIFT", "add_gates", "case_depth"]

FIRM_REFERENCE = (0.004, 1.0)
"""Of every contact, limit and gear: time constant in seconds and damping ratio."""

FIRM = (0.99, 0.999, 0.0005, 0.5, 2.0)
"""Of whatever locks: MuJoCo's impedance."""

_YIELDING = (0.9, 0.95, 0.001, 0.5, 2.0)
"""Of lifters and the stops of bolts, which bear no lock's load."""

LIFT = STROKE + 0.002
"""Way of a lifter, metres: the gap to its crossbar, and a little more than a bolt's stroke."""

_GAP = 0.001
_PITCH, _DEEPEST = 0.012, 0.15
_FIRST = 0.014
_CROSSBAR = 0.022
_SPACING = 0.009
_SPRING, _PRELOAD = 30.0, 1.0
_BOLT_ARMATURE, _BOLT_DAMPING = 0.008, 1.5
_STEEL = (0.6, 0.62, 0.65, 1.0)


def case_depth(gates: Sequence[Gate]) -> float:
    """How deep the case behind the board has to be, metres."""
    layers = _layers(gates)
    return 0.03 + (layers * _pitch(layers) if layers else 0.02)


def add_gates(spec: mujoco.MjSpec, body: mujoco.MjsBody, panel: Panel, gates: Sequence[Gate]) -> None:
    """Build every gate.

    The bolt of gate 2 is the joint ``bolt-2``; the lifters of a gate with several literals: ``lifter-2-0``, ...

    Args:
        spec: The scene; it is changed.
        body: The panel.
        panel: What is on it.
        gates: How its joints lock each other.
    """
    pitch = _pitch(_layers(gates))
    depth = -_FIRST
    for number, gate in enumerate(gates):
        fitting = panel.fittings[gate.joint]
        bolt = _add_bolt(body, f"bolt-{number}", fitting, depth)
        bolt.add_geom(name=f"pin-{number}", type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[PIN_RADIUS, 0, 0], **_PIECE)
        _add_blocks(spec, number, gate.joint, fitting, depth, pitch)
        if len(gate.literals) == 1:
            _gear(spec, f"bolt-{number}", gate.literals[0], panel, STROKE)
        else:
            depth -= pitch
            _add_lifters(spec, body, bolt, number, gate, panel, depth)
        depth -= pitch


_PIECE = {"mass": 0.005, "rgba": _STEEL, "group": HIDDEN, "contype": NOTHING, "conaffinity": NOTHING}


def _layers(gates: Sequence[Gate]) -> int:
    return sum(1 if len(gate.literals) == 1 else 2 for gate in gates)


def _pitch(layers: int) -> float:
    """Plates of many layers are thinner."""
    return min(_PITCH, _DEEPEST / max(layers, 1))


def _add_bolt(
    body: mujoco.MjsBody, name: str, fitting: Fitting, depth: float, *, back: float = 0.0, aside: float = 0.0
) -> mujoco.MjsBody:
    """A bolt that slides at right angles to a joint's way, from the pin's place or from behind and beside it."""
    (x, y), (ox, oy) = pin_of(fitting)
    part = body.add_body(name=name, pos=[x - back * ox - aside * oy, y - back * oy + aside * ox, depth])
    part.add_joint(
        name=name,
        type=mujoco.mjtJoint.mjJNT_SLIDE,
        axis=[ox, oy, 0],
        armature=_BOLT_ARMATURE,
        damping=[_BOLT_DAMPING, 0, 0],
        solref_limit=FIRM_REFERENCE,
        solimp_limit=_YIELDING,
    )
    return part


def _add_blocks(spec: mujoco.MjSpec, number: int, joint: int, fitting: Fitting, depth: float, pitch: float) -> None:
    part = spec.body(f"part-{joint}")
    for piece, block in enumerate(blocks_of(fitting)):
        name = f"block-{number}-{piece}"
        part.add_geom(
            name=name,
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[*block.half, 0.4 * pitch],
            pos=[block.middle[0] - fitting.origin[0], block.middle[1] - fitting.origin[1], depth],
            quat=_turned(block.angle),
            **_PIECE,
        )
        _touching(spec, f"pin-{number}", name)


def _add_lifters(
    spec: mujoco.MjSpec, body: mujoco.MjsBody, bolt: mujoco.MjsBody, number: int, gate: Gate, panel: Panel, depth: float
) -> None:
    """A sprung bolt with a crossbar in the next layer, under which every lifter pushes."""
    fitting = panel.fittings[gate.joint]
    (_, _), (ox, oy) = pin_of(fitting)
    spring = spec.joint(f"bolt-{number}")
    spring.stiffness = [_SPRING, 0, 0]
    spring.springref = -_PRELOAD / _SPRING
    spring.limited, spring.range = True, [0, LIFT + _GAP]
    half = 0.5 * _SPACING * len(gate.literals)
    crossbar = f"crossbar-{number}"
    bolt.add_geom(
        name=crossbar,
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[half, 0.004, 0.003],
        pos=[-_CROSSBAR * ox, -_CROSSBAR * oy, depth - bolt.pos[2]],
        quat=_turned(math.atan2(-ox, oy)),
        **_PIECE,
    )
    for place, literal in enumerate(gate.literals):
        name = f"lifter-{number}-{place}"
        aside = (place - (len(gate.literals) - 1) / 2) * _SPACING
        lifter = _add_bolt(body, name, fitting, depth, back=_CROSSBAR + 0.004 + PIN_RADIUS + _GAP, aside=aside)
        lifter.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[PIN_RADIUS, 0, 0], **_PIECE)
        _touching(spec, name, crossbar, _YIELDING)
        _gear(spec, name, literal, panel, LIFT)


def _gear(spec: mujoco.MjSpec, bolt: str, literal: Literal, panel: Panel, stroke: float) -> None:
    """Tie a bolt to a joint: all the way out where the joint stands as the literal asks."""
    joint, position = literal
    ratio = stroke / panel.fittings[joint].travel
    start, slope = (0.0, ratio) if position else (stroke, -ratio)
    spec.add_equality(
        type=mujoco.mjtEq.mjEQ_JOINT,
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
        name1=bolt,
        name2=f"joint-{joint}",
        data=[start, slope] + [0.0] * 10,
        solref=FIRM_REFERENCE,
        solimp=FIRM,
    )


def _touching(spec: mujoco.MjSpec, first: str, second: str, impedance: Sequence[float] = FIRM) -> None:
    spec.add_pair(geomname1=first, geomname2=second, condim=1, solref=FIRM_REFERENCE, solimp=impedance)


def _turned(angle: float) -> list[float]:
    return [math.cos(angle / 2), 0, 0, math.sin(angle / 2)]
