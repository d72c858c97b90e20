"""The interlock in MuJoCo: bolts, pins, blocks and lifters behind the board, each gate in a separate layer.

Only two pairs of parts can collide: a pin and its block, a lifter and its crossbar. Contacts are frictionless and
stiff.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import mujoco

from lockprobe_robot.box_model.gates import PIN_RADIUS, STROKE, Gate, blocks_of, pin_of
from lockprobe_robot.box_model.mounted_joint import ALUMINIUM, MountedJoint
from lockprobe_robot.box_model.panel import PanelLayout
from lockprobe_robot.geom_groups import HIDDEN, NOTHING

FIRM_REFERENCE = (0.004, 1.0)
"""Time constant in seconds and damping ratio of every contact, limit and gear."""

FIRM = (0.99, 0.999, 0.0005, 0.5, 2.0)
"""MuJoCo's impedance of the parts that lock."""

_YIELDING = (0.9, 0.95, 0.001, 0.5, 2.0)
"""MuJoCo's impedance of lifters and stops of bolts, which carry no locking load."""

LIFT = STROKE + 0.002
"""Stroke of a lifter, metres: the gap to its crossbar plus a little more than a bolt's stroke."""

_GAP = 0.001
_PITCH, _DEEPEST = 0.012, 0.15
_FIRST = 0.014
_CROSSBAR = 0.022
_SPACING = 0.009
_SPRING, _PRELOAD = 30.0, 1.0
_BOLT_MASS, _BOLT_DAMPING = 0.02, 1.5
_STEEL = (0.6, 0.62, 0.65, 1.0)


def case_depth(gates: Sequence[Gate]) -> float:
    """Depth that the case behind the board needs, metres."""
    layers, pitch = _layers(gates)
    return 0.03 + (layers * pitch if layers else 0.02)


def add_gates(
    spec: mujoco.MjSpec, body: mujoco.MjsBody, panel: PanelLayout, gates: Sequence[Gate], names: Sequence[str]
) -> None:
    """Build every gate behind the body of the panel.

    The bolt of gate 2 is the joint ``bolt-2``; the lifters of a gate with several literals: ``lifter-2-0``, ...
    """
    (_, pitch), depth = _layers(gates), -_FIRST
    for number, gate in enumerate(gates):
        mounted = panel.mounted_joints[gate.joint]
        bolt = _add_bolt(body, f"bolt-{number}", mounted, depth)
        bolt.add_geom(name=f"pin-{number}", type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[PIN_RADIUS, 0, 0], **_BOLT)
        part = spec.body(f"part-{gate.joint}")
        for piece, ((x, y), angle, half) in enumerate(blocks_of(mounted)):
            part.add_geom(
                name=f"block-{number}-{piece}",
                type=mujoco.mjtGeom.mjGEOM_BOX,
                size=[*half, 0.4 * pitch],
                pos=[x - mounted.origin[0], y - mounted.origin[1], depth],
                quat=_turned(angle),
                density=ALUMINIUM,
                **_PIECE,
            )
            _touching(spec, f"pin-{number}", f"block-{number}-{piece}")
        gears = [(f"bolt-{number}", literal, STROKE) for literal in gate.literals]
        if len(gate.literals) != 1:
            # The bolt is sprung, with a crossbar in the next layer, which every lifter can push up.
            depth -= pitch
            _, (ox, oy) = pin_of(mounted)
            spring, crossbar = spec.joint(f"bolt-{number}"), f"crossbar-{number}"
            spring.stiffness, spring.springref = [_SPRING, 0, 0], -_PRELOAD / _SPRING
            spring.limited, spring.range = True, [0, LIFT + _GAP]
            bolt.add_geom(
                name=crossbar,
                type=mujoco.mjtGeom.mjGEOM_BOX,
                size=[0.5 * _SPACING * len(gate.literals), 0.004, 0.003],
                pos=[-_CROSSBAR * ox, -_CROSSBAR * oy, depth - bolt.pos[2]],
                quat=_turned(math.atan2(-ox, oy)),
                density=ALUMINIUM,
                **_PIECE,
            )
            gears = [(f"lifter-{number}-{index}", literal, LIFT) for index, literal in enumerate(gate.literals)]
            for index, (name, _, _) in enumerate(gears):
                aside = (index - (len(gears) - 1) / 2) * _SPACING
                lifter = _add_bolt(body, name, mounted, depth, back=_CROSSBAR + 0.004 + PIN_RADIUS + _GAP, aside=aside)
                lifter.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[PIN_RADIUS, 0, 0], **_BOLT)
                _touching(spec, name, crossbar, _YIELDING)
        for name, (joint, position), stroke in gears:  # so that a bolt is fully retracted while the literal holds
            ratio = stroke / panel.mounted_joints[joint].travel
            start, slope = (0.0, ratio) if position else (stroke, -ratio)
            spec.add_equality(
                type=mujoco.mjtEq.mjEQ_JOINT,
                objtype=mujoco.mjtObj.mjOBJ_JOINT,
                name1=name,
                name2=names[joint],
                data=[start, slope] + [0.0] * 10,
                solref=FIRM_REFERENCE,
                solimp=FIRM,
            )
        depth -= pitch


_PIECE = {"rgba": _STEEL, "group": HIDDEN, "contype": NOTHING, "conaffinity": NOTHING}
_BOLT = {"mass": _BOLT_MASS, **_PIECE}


def _layers(gates: Sequence[Gate]) -> tuple[int, float]:
    """The number of layers, and the thickness of each: many are thinner."""
    layers = sum(1 if len(gate.literals) == 1 else 2 for gate in gates)
    return layers, min(_PITCH, _DEEPEST / max(layers, 1))


def _add_bolt(
    body: mujoco.MjsBody, name: str, mounted: MountedJoint, depth: float, *, back: float = 0.0, aside: float = 0.0
) -> mujoco.MjsBody:
    """Add a bolt that slides perpendicular to a joint's motion, starting at the pin or shifted back and aside."""
    (x, y), (ox, oy) = pin_of(mounted)
    part = body.add_body(name=name, pos=[x - back * ox - aside * oy, y - back * oy + aside * ox, depth])
    part.add_joint(
        name=name,
        type=mujoco.mjtJoint.mjJNT_SLIDE,
        axis=[ox, oy, 0],
        damping=[_BOLT_DAMPING, 0, 0],
        solref_limit=FIRM_REFERENCE,
        solimp_limit=_YIELDING,
    )
    return part


def _touching(spec: mujoco.MjSpec, first: str, second: str, impedance: Sequence[float] = FIRM) -> None:
    spec.add_pair(geomname1=first, geomname2=second, condim=1, solref=FIRM_REFERENCE, solimp=impedance)


def _turned(angle: float) -> list[float]:
    return [math.cos(angle / 2), 0, 0, math.sin(angle / 2)]
