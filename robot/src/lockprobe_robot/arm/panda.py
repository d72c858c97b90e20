"""The Franka Emika Panda arm from published parameters, built of primitive shapes.

Joint axes and offsets are the manufacturer's Denavit-Hartenberg parameters (Craig's convention); limits come from its
data sheet. Masses, centres of mass and inertia were identified by Gaz et al., "Dynamic Identification of the
Franka Emika Panda Robot With Retrieval of Feasible Parameters" (RA-L 2019). Shapes are capsules and
cylinders; they collide with the panel and never with each other.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe_robot.geom_groups import ARM, PANEL

JOINTS = 7

DH = (
    (0.0, 0.333, 0.0),
    (0.0, 0.0, -math.pi / 2),
    (0.0, 0.316, math.pi / 2),
    (0.0825, 0.0, math.pi / 2),
    (-0.0825, 0.384, -math.pi / 2),
    (0.0, 0.0, math.pi / 2),
    (0.088, 0.0, math.pi / 2),
)
"""Length a and offset d in metres and twist alpha in radians before each joint (Craig's convention)."""

FLANGE = 0.107
"""Distance from the last joint to the flange along its axis, metres."""

LOWER = np.array([-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973])
UPPER = np.array([2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973])
"""Joint limits, radians."""

VELOCITY_LIMITS = np.array([2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61])
"""Radians per second."""

ACCELERATION_LIMITS = np.array([15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0])
"""Radians per second squared."""

TORQUE_LIMITS = np.array([87.0, 87.0, 87.0, 87.0, 12.0, 12.0, 12.0])
"""Newton metres."""

HOME = np.array([0.0, -1.5, 0.0, -2.5, 0.0, 1.2, math.pi / 4])
"""Drawn back, out of the camera's view, radians."""

_ARMATURE = 0.1
_DAMPING = 0.5

_WHITE = (0.93, 0.93, 0.92, 1.0)
_GREY = (0.34, 0.35, 0.37, 1.0)


@dataclass(frozen=True, slots=True)
class Link:
    """Mass and inertia of one link in the frame of its joint.

    Attributes:
        mass: Kilograms.
        centre: Centre of mass, metres.
        inertia: About the centre of mass: xx, yy, zz, xy, xz, yz, kg m^2.
    """

    mass: float
    centre: tuple[float, float, float]
    inertia: tuple[float, float, float, float, float, float]


LINKS = (
    Link(4.970684, (3.875e-3, 2.081e-3, -4.762e-2), (0.70337, 0.70661, 9.117e-3, -1.39e-4, 6.772e-3, 1.9169e-2)),
    Link(0.646926, (-3.141e-3, -2.872e-2, 3.495e-3), (7.962e-3, 2.811e-2, 2.5995e-2, -3.925e-3, 1.0254e-2, 7.04e-4)),
    Link(
        3.228604,
        (2.7518e-2, 3.9252e-2, -6.6502e-2),
        (3.7242e-2, 3.6155e-2, 1.083e-2, -4.761e-3, -1.1396e-2, -1.2805e-2),
    ),
    Link(
        3.587895,
        (-5.317e-2, 1.04419e-1, 2.7454e-2),
        (2.5853e-2, 1.9552e-2, 2.8323e-2, 7.796e-3, -1.332e-3, 8.641e-3),
    ),
    Link(
        1.225946,
        (-1.1953e-2, 4.1065e-2, -3.8437e-2),
        (3.5549e-2, 2.9474e-2, 8.627e-3, -2.117e-3, -4.037e-3, 2.29e-4),
    ),
    Link(
        1.666555,
        (6.0149e-2, -1.4117e-2, -1.0517e-2),
        (1.964e-3, 4.354e-3, 5.433e-3, 1.09e-4, -1.158e-3, 3.41e-4),
    ),
    Link(
        0.735522,
        (1.0517e-2, -4.252e-3, 6.1597e-2),
        (1.2516e-2, 1.0027e-2, 4.815e-3, -4.28e-4, -1.196e-3, -7.41e-4),
    ),
)
"""The moving links in order."""

_Segment = tuple[tuple[float, float, float], tuple[float, float, float], float, str, tuple[float, float, float, float]]
"""From, to, radius, shape, colour, in the frame of the link's joint."""

_BASE: tuple[_Segment, ...] = (
    ((-0.06, 0.0, 0.0), (-0.06, 0.0, 0.055), 0.095, "cylinder", _WHITE),
    ((0.0, 0.0, 0.0), (0.0, 0.0, 0.14), 0.075, "cylinder", _WHITE),
    ((-0.13, 0.0, 0.03), (0.0, 0.0, 0.08), 0.05, "capsule", _WHITE),
)

_SHAPES: tuple[tuple[_Segment, ...], ...] = (
    (
        ((0.0, 0.0, -0.192), (0.0, 0.0, -0.175), 0.076, "cylinder", _GREY),
        ((0.0, 0.0, -0.175), (0.0, 0.0, -0.03), 0.064, "capsule", _WHITE),
        ((0.0, -0.068, 0.0), (0.0, 0.068, 0.0), 0.064, "cylinder", _WHITE),
    ),
    (
        ((0.0, 0.0, -0.078), (0.0, 0.0, 0.078), 0.056, "cylinder", _GREY),
        ((0.0, -0.03, 0.0), (0.0, -0.17, 0.0), 0.060, "capsule", _WHITE),
    ),
    (
        ((0.0, 0.0, -0.142), (0.0, 0.0, -0.126), 0.066, "cylinder", _GREY),
        ((0.0, 0.0, -0.13), (0.06, 0.0, -0.01), 0.056, "capsule", _WHITE),
        ((0.0825, -0.062, 0.0), (0.0825, 0.062, 0.0), 0.060, "cylinder", _WHITE),
    ),
    (
        ((0.0, 0.0, -0.072), (0.0, 0.0, 0.072), 0.052, "cylinder", _GREY),
        ((-0.02, 0.02, 0.0), (-0.0825, 0.10, 0.0), 0.056, "capsule", _WHITE),
    ),
    (
        ((0.0, 0.0, -0.272), (0.0, 0.0, -0.256), 0.062, "cylinder", _GREY),
        ((0.0, 0.0, -0.25), (0.0, 0.045, -0.16), 0.055, "capsule", _WHITE),
        ((0.0, 0.045, -0.16), (0.0, 0.01, -0.03), 0.046, "capsule", _WHITE),
        ((0.0, 0.0, -0.06), (0.0, 0.0, 0.0), 0.048, "capsule", _WHITE),
    ),
    (
        ((0.0, 0.0, -0.066), (0.0, 0.0, 0.062), 0.044, "cylinder", _GREY),
        ((0.0, 0.0, 0.0), (0.07, 0.0, 0.0), 0.047, "capsule", _WHITE),
    ),
    (
        ((0.0, 0.0, -0.05), (0.0, 0.0, 0.06), 0.045, "cylinder", _WHITE),
        ((0.0, 0.0, 0.06), (0.0, 0.0, 0.1), 0.040, "cylinder", _WHITE),
        ((0.0, 0.0, 0.1), (0.0, 0.0, 0.107), 0.0335, "cylinder", _GREY),
    ),
)
"""Visible shapes of each moving link; they are also what can touch the panel."""


def _dh_transform(a: float, d: float, alpha: float, theta: float) -> NDArray[np.float64]:
    """The pose of a joint's frame in the previous frame, Craig's convention, shape (4, 4)."""
    ca, sa, ct, st = math.cos(alpha), math.sin(alpha), math.cos(theta), math.sin(theta)
    return np.array([[ct, -st, 0, a], [st * ca, ct * ca, -sa, -d * sa], [st * sa, ct * sa, ca, d * ca], [0, 0, 0, 1.0]])


def add_panda(spec: mujoco.MjSpec) -> mujoco.MjsBody:
    """Add the arm at the world's origin, x forward, with torque motors.

    Bodies are called ``link0`` to ``link7``, joints ``arm-1`` to ``arm-7``, motors as their joints.

    Args:
        spec: The scene; it is changed.

    Returns:
        The flange, to which a hand is mounted; its z axis points away from the arm.
    """
    unit = math.degrees(1) if spec.compiler.degree else 1.0
    body = spec.worldbody.add_body(name="link0")
    _add_shapes(body, _BASE, mass=1.0)  # it stands, but a body without mass is an error in older versions of MuJoCo
    for number, ((a, d, alpha), link, shapes) in enumerate(zip(DH, LINKS, _SHAPES, strict=True), start=1):
        pose = _dh_transform(a, d, alpha, 0.0)
        body = body.add_body(
            name=f"link{number}", pos=pose[:3, 3], quat=[math.cos(alpha / 2), math.sin(alpha / 2), 0, 0]
        )
        body.explicitinertial = True
        body.mass, body.ipos, body.fullinertia = link.mass, link.centre, link.inertia
        body.add_joint(
            name=f"arm-{number}",
            type=mujoco.mjtJoint.mjJNT_HINGE,
            axis=[0, 0, 1],
            range=[unit * LOWER[number - 1], unit * UPPER[number - 1]],
            limited=True,
            armature=_ARMATURE,
            damping=[_DAMPING, 0, 0],
        )
        _add_shapes(body, shapes)
        most = TORQUE_LIMITS[number - 1]
        motor = spec.add_actuator(
            name=f"arm-{number}",
            target=f"arm-{number}",
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            ctrlrange=[-most, most],
            ctrllimited=True,
        )
        motor.set_to_motor()
    return body.add_body(name="flange", pos=[0, 0, FLANGE])


def _add_shapes(body: mujoco.MjsBody, shapes: Sequence[_Segment], *, mass: float = 0.0) -> None:
    for start, end, radius, shape, colour in shapes:
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CAPSULE if shape == "capsule" else mujoco.mjtGeom.mjGEOM_CYLINDER,
            fromto=[*start, *end],
            size=[radius, 0, 0],
            rgba=colour,
            mass=mass,
            contype=ARM,
            conaffinity=PANEL,
        )
