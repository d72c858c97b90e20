"""A compliant hand that cages a knob between six soft fingers, mounted on a force-torque sensor.

It approximates a soft hand: each finger is a capsule on two sprung hinges. The fingers lean outwards, so they still
enclose a knob that is slightly off its believed position. The gap between fingers is narrower than a knob, so a knob
escapes only by bending two fingers aside, which soft fingers allow.
"""

from __future__ import annotations

import math

import mujoco

from lockprobe_robot.geom_groups import ARM, HIDDEN, PANEL

FINGERS = 6

TOOL = 0.108
"""Distance from the flange to the middle of the cage, which holds the top of a knob, metres."""

REACH = 0.026
"""Distance of the fingertips beyond that point, metres."""

HAND_RADIUS = 0.044
"""Radius of the circle of the fingertips, metres."""

_ROOT = 0.05
_ROOT_RING = 0.028
_THICKNESS = 0.0065
_TIP_RING = HAND_RADIUS - _THICKNESS
_STIFFNESS = 100.0
_DAMPING = 0.2
_FRICTION = 0.3
_ARMATURE = 2e-4
_STOP = 0.5

_DARK = (0.16, 0.17, 0.19, 1.0)
_RUBBER = (0.93, 0.45, 0.13, 1.0)


def add_hand(spec: mujoco.MjSpec, flange: mujoco.MjsBody) -> None:
    """Mount the hand on the flange.

    Sites: ``tool`` in the middle of the cage, z away from the arm, and ``wrench`` at the flange. Sensors: ``force`` and
    ``torque`` between flange and hand, in the frame of ``wrench``. Joints: ``finger-0-bend`` (outwards) and
    ``finger-0-splay`` (sideways) and so on.

    Args:
        spec: The scene; it is changed.
        flange: The body that carries the hand.
    """
    hand = flange.add_body(name="hand")
    for name, height in (("wrench", 0.0), ("tool", TOOL)):
        hand.add_site(name=name, pos=[0, 0, height], group=HIDDEN)
    for start, end, radius, mass, colour in (
        (0.0, 0.012, 0.038, 0.15, (0.72, 0.73, 0.75, 1.0)),
        (0.012, 0.018, 0.036, 0.0, _DARK),
        (0.018, _ROOT, 0.040, 0.35, _DARK),
    ):
        hand.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CYLINDER,
            fromto=[0, 0, start, 0, 0, end],
            size=[radius, 0, 0],
            mass=mass,
            rgba=colour,
            contype=ARM,
            conaffinity=PANEL,
        )
    for kind, name in ((mujoco.mjtSensor.mjSENS_FORCE, "force"), (mujoco.mjtSensor.mjSENS_TORQUE, "torque")):
        spec.add_sensor(name=name, type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname="wrench")
    for number in range(FINGERS):
        _add_finger(spec, hand, number)


def _add_finger(spec: mujoco.MjSpec, hand: mujoco.MjsBody, number: int) -> None:
    angle = 2 * math.pi * number / FINGERS
    out = (math.cos(angle), math.sin(angle))
    finger = hand.add_body(name=f"finger-{number}", pos=[_ROOT_RING * out[0], _ROOT_RING * out[1], _ROOT])
    stop = _STOP if not spec.compiler.degree else math.degrees(_STOP)
    for name, axis in (("bend", (-out[1], out[0], 0.0)), ("splay", (out[0], out[1], 0.0))):
        finger.add_joint(
            name=f"finger-{number}-{name}",
            type=mujoco.mjtJoint.mjJNT_HINGE,
            axis=axis,
            stiffness=[_STIFFNESS, 0, 0],
            damping=[_DAMPING, 0, 0],
            armature=_ARMATURE,
            range=[-stop, stop],
            limited=True,
        )
    lean, length = _TIP_RING - _ROOT_RING, TOOL + REACH - _THICKNESS - _ROOT
    finger.add_geom(
        name=f"finger-{number}",
        type=mujoco.mjtGeom.mjGEOM_CAPSULE,
        fromto=[0, 0, 0, lean * out[0], lean * out[1], length],
        size=[_THICKNESS, 0, 0],
        mass=0.015,
        rgba=_RUBBER,
        friction=[_FRICTION, 0.005, 0.0001],
        priority=1,
        contype=ARM,
        conaffinity=PANEL,
    )
