"""A hand for knobs: a ring on three struts, on a compliant plate, on a force-torque sensor.

It is no model of the paper's soft RBO Hand 3. The ring goes down over a knob and drags it along. It is wider than the
knob, and fins lead the knob in, so it may stand beside where the robot believes it. The plate yields sideways, as a
remote centre compliance does: it softens the moment in which the ring meets a knob that is held. Its stiffness and its
weight are chosen by eye.
"""

from __future__ import annotations

import math

import mujoco

from lockprobe_robot.geom_groups import ARM, HIDDEN, PANEL

TOOL = 0.108
"""Distance from the flange to the point that holds the middle of a knob's top, metres."""

REACH = 0.012
"""Distance of the ring beyond that point, metres: it holds a knob below its top."""

RING, THICKNESS = 0.034, 0.004
"""Radius of the ring, and of the rod that it is bent of, metres."""

FLARE = 0.0405
"""Radius at the lower ends of the fins, metres."""

_FIN = 0.012
"""How far the fins reach beyond the ring, metres."""

_SEGMENTS, _STRUTS = 16, 3
_PLATE = 0.055
"""Distance from the flange to the plate, metres."""

_STIFFNESS, _DAMPING, _YIELDS = 3000.0, 30.0, 0.010
"""Of the plate along x and y: newtons per metre, newtons per metre and second, and the most that it yields, metres."""

_FRICTION = 0.15
_DARK, _STEEL, _RUBBER = (0.13, 0.14, 0.16, 1.0), (0.75, 0.77, 0.80, 1.0), (0.96, 0.46, 0.10, 1.0)
_TOUCHES = {"contype": ARM, "conaffinity": PANEL}


def add_hand(spec: mujoco.MjSpec, flange: mujoco.MjsBody) -> None:
    """Mount the hand on the flange.

    Sites: ``tool`` where the middle of a knob's top is held, z away from the arm, ``wrench`` at the flange. Sensors:
    ``force`` and ``torque`` between flange and hand, in the frame of ``wrench``. Joints: ``hand-x`` and ``hand-y`` of
    the plate.

    Args:
        spec: The scene; it is changed.
        flange: The body that carries the hand.
    """
    hand = flange.add_body(name="hand")
    hand.add_site(name="tool", pos=[0, 0, TOOL], group=HIDDEN)
    add_wrench(spec, hand)
    for start, end, radius, mass, colour in (
        (0.0, 0.010, 0.036, 0.15, _STEEL),
        (0.010, 0.034, 0.040, 0.30, _DARK),
        (0.034, _PLATE - 0.006, 0.030, 0.05, _STEEL),
    ):
        _rod(hand, (0, 0, start), (0, 0, end), radius, colour, mass=mass, shape=mujoco.mjtGeom.mjGEOM_CYLINDER)
    plate = hand.add_body(name="plate", pos=[0, 0, _PLATE])
    for name, axis in (("hand-x", (1, 0, 0)), ("hand-y", (0, 1, 0))):
        plate.add_joint(
            name=name,
            type=mujoco.mjtJoint.mjJNT_SLIDE,
            axis=axis,
            stiffness=[_STIFFNESS, 0, 0],
            damping=[_DAMPING, 0, 0],
            range=[-_YIELDS, _YIELDS],
            limited=True,
        )
    _rod(plate, (0, 0, -0.004), (0, 0, 0.004), 0.041, _DARK, mass=0.08, shape=mujoco.mjtGeom.mjGEOM_CYLINDER)
    depth = TOOL + REACH - _PLATE
    ring = [
        (RING * math.cos(angle), RING * math.sin(angle), depth)
        for angle in (2 * math.pi * number / _SEGMENTS for number in range(_SEGMENTS))
    ]
    for number, point in enumerate(ring):
        _rod(plate, point, ring[number - 1], THICKNESS, _RUBBER, mass=0.04 / _SEGMENTS)
        flare = FLARE / RING
        _rod(plate, point, (flare * point[0], flare * point[1], depth + _FIN), 0.0035, _RUBBER, mass=0.001)
    for number in range(_STRUTS):
        x, y, _ = ring[number * _SEGMENTS // _STRUTS]
        _rod(plate, (x, y, 0), (x, y, depth), 0.004, _STEEL, mass=0.01)


def add_wrench(spec: mujoco.MjSpec, hand: mujoco.MjsBody) -> None:
    """Add the force-torque sensor between the flange and a hand."""
    hand.add_site(name="wrench", group=HIDDEN)
    for kind, name in ((mujoco.mjtSensor.mjSENS_FORCE, "force"), (mujoco.mjtSensor.mjSENS_TORQUE, "torque")):
        spec.add_sensor(name=name, type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname="wrench")


def _rod(
    body: mujoco.MjsBody,
    start: tuple[float, float, float],
    end: tuple[float, float, float],
    radius: float,
    colour: tuple[float, float, float, float],
    *,
    mass: float,
    shape: mujoco.mjtGeom = mujoco.mjtGeom.mjGEOM_CAPSULE,
) -> None:
    body.add_geom(
        type=shape,
        fromto=[*start, *end],
        size=[radius, 0, 0],
        mass=mass,
        rgba=colour,
        friction=[_FRICTION, 0.005, 0.0001],
        priority=1,
        **_TOUCHES,
    )
