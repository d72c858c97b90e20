"""Small objects that lie on the board: they are only seen, and hide neither labels nor what a joint sweeps."""

from __future__ import annotations

import colorsys
import math
from typing import Final

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe_robot.box_model.panel import PanelLayout, covered_area
from lockprobe_robot.geom_groups import NOTHING

_RADII: Final = (0.006, 0.012)
"""Least and greatest radius of an object, metres."""

_HEIGHTS: Final = (0.006, 0.018)
_GAP: Final = 0.006
"""Least distance between an object and what must stay free, metres."""

_LETTER: Final = 0.8
"""Radius around a label that stays free, in heights of a letter."""

_TRIES: Final = 200
"""Places that are tried for an object before the board counts as full."""

_SOLIDS: Final = (mujoco.mjtGeom.mjGEOM_CYLINDER, mujoco.mjtGeom.mjGEOM_BOX, mujoco.mjtGeom.mjGEOM_ELLIPSOID)


def add_clutter(board: mujoco.MjsBody, panel: PanelLayout, eye: NDArray[np.float64], *, count: int, luck: int) -> None:
    """Add objects in turn, until the board is full. More objects are the same and further ones.

    Args:
        board: The body of the panel.
        panel: Its layout.
        eye: Position of the camera in the world, metres.
        count: Number of objects.
        luck: Seed of places, shapes and colours.
    """
    if not count:
        return
    rng = np.random.Generator(np.random.PCG64(luck))
    across, ahead, up = panel.pose[:3, :3].T @ (eye - panel.pose[:3, 3])
    swept = np.concatenate([covered_area(mounted, math.atan2(ahead, up)) for mounted in panel.mounted_joints])
    taken = np.concatenate([swept, panel.labels])
    radii = np.array([0.0] * len(swept) + [_LETTER * panel.letter] * len(panel.labels))
    for number in range(count):
        size, tall, hue, full, bright, turn = rng.random(6)
        solid = _SOLIDS[int(rng.integers(len(_SOLIDS)))]
        radius = _RADII[0] + size * (_RADII[1] - _RADII[0])
        height = _HEIGHTS[0] + tall * (_HEIGHTS[1] - _HEIGHTS[0])
        for place in (2 * rng.random((_TRIES, 2)) - 1) * (np.array(panel.size) / 2 - radius - _GAP):
            # From the camera the object hides the board behind it, and a joint there would be hidden, too.
            away = (place - (across, ahead)) * height / (up - height)
            hidden = place + np.linspace(0, 1, 4)[:, None] * away
            gaps = np.linalg.norm(taken - hidden[:, None], axis=-1).min(0)
            if (gaps > radii + radius + _GAP).all():
                break
        else:
            return
        taken, radii = np.concatenate([taken, hidden]), np.concatenate([radii, np.full(len(hidden), radius)])
        half = radius / math.sqrt(2) if solid == mujoco.mjtGeom.mjGEOM_BOX else radius
        board.add_geom(
            name=f"clutter-{number}",
            type=solid,
            size=[half, height / 2, 0] if solid == mujoco.mjtGeom.mjGEOM_CYLINDER else [half, half, height / 2],
            pos=[*place, height / 2],
            quat=[math.cos(math.pi * turn), 0, 0, math.sin(math.pi * turn)],
            rgba=[*colorsys.hsv_to_rgb(float(hue), 0.3 + 0.6 * float(full), 0.35 + 0.6 * float(bright)), 1],
            mass=0,
            contype=NOTHING,
            conaffinity=NOTHING,
        )
