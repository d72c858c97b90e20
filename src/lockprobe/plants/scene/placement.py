"""Where the panel stands in the world, and where the camera hangs."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

__all__ = ["CAMERA_DISTANCE", "camera_angle", "panel_pose"]

CAMERA_DISTANCE = 0.72
"""From the middle of the board to the camera, metres."""

_CAMERA_LAG, _CAMERA_LEAN = math.radians(12), math.radians(40)

_HEIGHT, _RAISED = 0.16, 0.63
"""Of the middle of a board tilted by no more than 20 degrees, metres; and for every radian beyond, metres."""


def camera_angle(tilt: float) -> float:
    """Between the panel's normal and the way to the camera, radians, positive if the camera is above the normal.

    The camera leans towards the robot as the panel does, less ``_CAMERA_LAG``, but only as far as it stays clear of an
    arm at home.

    Args:
        tilt: Radians.
    """
    return tilt - min(max(tilt - _CAMERA_LAG, 0.0), _CAMERA_LEAN)


def panel_pose(size: tuple[float, float], tilt: float, depth: float) -> NDArray[np.float64]:
    """Where a panel stands in the world: before the robot, its case above the ground. Shape (4, 4), metres.

    It stands the higher the steeper it is: no angles of the arm's joints would bend the hand under a low, steep panel.
    """
    sine, cosine = math.sin(tilt), math.cos(tilt)
    pose = np.eye(4)
    pose[:3, 0] = (0, -1, 0)
    pose[:3, 1] = (cosine, 0, sine)
    pose[:3, 2] = (-sine, 0, cosine)
    lowest = 0.5 * size[1] * sine + depth * cosine
    pose[:3, 3] = (0.5, 0, max(_HEIGHT, lowest + 0.03, _HEIGHT + _RAISED * (tilt - math.radians(20))))
    return pose
