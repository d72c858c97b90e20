"""The arm and its hand in a scene, as their MJCF files have them: ``panda.xml`` and ``hand.xml``; and their limits."""

from __future__ import annotations

import math
from pathlib import Path

import mujoco
import numpy as np

from lockprobe_robot.geom_groups import ARM, HIDDEN, PANEL

JOINTS = 7

VELOCITY_LIMITS = np.array([2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61])
"""Radians per second."""

ACCELERATION_LIMITS = np.array([15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0])
"""Radians per second squared."""

HOME = np.array([0.0, -1.5, 0.0, -2.5, 0.0, 1.2, math.pi / 4])
"""Drawn back, out of the camera's view, radians."""

TOOL = 0.108
"""Distance from the flange to the point of our hand that holds the middle of a knob's top, metres."""

TOOL_SITE = "tool"
"""The site of a hand that holds the middle of a knob's top, z away from the arm."""


def add_arm(spec: mujoco.MjSpec) -> mujoco.MjsBody:
    """Add the arm at the world's origin, x forward, with torque motors.

    Bodies are called ``arm-link0`` to ``arm-link7``, joints and motors ``arm-1`` to ``arm-7``.
    Returned is the flange, to which a hand is mounted; its z axis points away from the arm.
    """
    spec.attach(_own("panda"), prefix="arm-", frame=spec.worldbody.add_frame())
    return spec.body("arm-flange")


def add_hand(spec: mujoco.MjSpec, flange: mujoco.MjsBody, hand: mujoco.MjSpec | None = None) -> None:
    """Mount a hand on the flange, over a force-torque sensor.

    All bodies of the hand hang on the flange, with their joints, motors and sensors; ``hand-`` is put before their
    names, except that of the site ``tool``. What can touch anything touches the panel and nothing else. The sensors
    ``force`` and ``torque`` measure between flange and hand, in the frame of the site ``wrench``.
    Ours is mounted where no other hand is given.
    """
    hand = hand or _own("hand")
    for geom in hand.geoms:
        if geom.contype or geom.conaffinity:
            geom.contype, geom.conaffinity = ARM, PANEL
    mount = flange.add_body(name="hand")
    mount.add_site(name="wrench", group=HIDDEN)
    for kind, name in ((mujoco.mjtSensor.mjSENS_FORCE, "force"), (mujoco.mjtSensor.mjSENS_TORQUE, "torque")):
        spec.add_sensor(name=name, type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname="wrench")
    spec.assets = {**spec.assets, **hand.assets}
    spec.attach(hand, prefix="hand-", frame=mount.add_frame())
    spec.site(f"hand-{TOOL_SITE}").name = TOOL_SITE


def _own(name: str) -> mujoco.MjSpec:
    return mujoco.MjSpec.from_file(str(Path(__file__).with_name(f"{name}.xml")))
