"""The handle of a joint: one and the same round knob to the touch, in several shapes to the eye."""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe.plants.layers import HIDDEN, NOTHING, PANEL
from lockprobe.plants.scene.appearance import Colour, Look
from lockprobe.plants.scene.fitting import KNOB_RADIUS, KNOB_TOP

__all__ = ["add_handle"]

_BASE = 0.002
_DARK: Colour = (0.12, 0.12, 0.13)


def add_handle(part: mujoco.MjsBody, number: int, place: NDArray[np.float64], look: Look) -> None:
    """Put a handle onto a moving part, with a site in the middle of its top.

    Args:
        part: The moving part.
        number: Of the joint, in panel order.
        place: Middle of the handle in the frame of the part, metres.
        look: Its shape and colour.
    """
    x, y = place
    part.add_site(name=f"knob-{number}", pos=[x, y, KNOB_TOP], group=HIDDEN)
    seen = look.handle == "round"
    part.add_geom(
        name=f"knob-{number}",
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=[KNOB_RADIUS, (KNOB_TOP - _BASE) / 2, 0],
        pos=[x, y, (KNOB_TOP + _BASE) / 2],
        rgba=[*look.knob, 1],
        mass=0.03,
        group=0 if seen else HIDDEN,
        contype=PANEL,
        conaffinity=NOTHING,
    )
    if look.handle == "capped":
        _cylinder(part, place, 0.010, _BASE, 0.032, _DARK)
        _cylinder(part, place, KNOB_RADIUS, 0.032, KNOB_TOP, look.knob)
    elif look.handle == "ball":
        _cylinder(part, place, 0.008, _BASE, KNOB_TOP - KNOB_RADIUS, _DARK)
        part.add_geom(
            type=mujoco.mjtGeom.mjGEOM_SPHERE,
            size=[KNOB_RADIUS, 0, 0],
            pos=[x, y, KNOB_TOP - KNOB_RADIUS],
            rgba=[*look.knob, 1],
            mass=0,
            contype=NOTHING,
            conaffinity=NOTHING,
        )
    elif look.handle == "grooved":
        for low, high, radius, colour in (
            (_BASE, 0.016, KNOB_RADIUS, look.knob),
            (0.016, 0.026, 0.012, _DARK),
            (0.026, KNOB_TOP, KNOB_RADIUS, look.knob),
        ):
            _cylinder(part, place, radius, low, high, colour)


def _cylinder(
    part: mujoco.MjsBody, place: NDArray[np.float64], radius: float, low: float, high: float, colour: Colour
) -> None:
    part.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=[radius, (high - low) / 2, 0],
        pos=[place[0], place[1], (low + high) / 2],
        rgba=[*colour, 1],
        mass=0,
        contype=NOTHING,
        conaffinity=NOTHING,
    )
