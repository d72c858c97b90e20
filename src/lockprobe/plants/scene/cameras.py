"""The cameras of a scene: one hangs above the board, one looks at it all from aside."""

from __future__ import annotations

import math

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe.plants.scene.appearance import Look
from lockprobe.plants.scene.fitting import KNOB_TOP
from lockprobe.plants.scene.panel import Panel
from lockprobe.plants.scene.placement import CAMERA_DISTANCE, camera_angle

__all__ = ["EYE", "add_cameras"]

EYE = "rgbd"
"""Name of the plant's camera."""

_FILM = "oblique"

_MARGIN = 0.08
"""Around the board in pictures of the plant's camera, as a share of their width or height."""


def add_cameras(spec: mujoco.MjSpec, panel: Panel, look: Look, *, aspect: float) -> None:
    """Hang up both cameras. The plant's sees the whole board with a margin; an arm at home is clear of it.

    Args:
        spec: The scene; it is changed.
        panel: Where the board stands.
        look: By how much the plant's camera is out of its place.
        aspect: Width of the plant's pictures as a multiple of their height.
    """
    middle = panel.pose[:3, 3]
    lean = panel.tilt - camera_angle(panel.tilt)
    away = np.array([-math.sin(lean), 0, math.cos(lean)])
    axes = np.array([[0, -1, 0], [math.cos(lean), 0, math.sin(lean)], away]).T
    place = middle + CAMERA_DISTANCE * away
    width, height = panel.size
    corners = np.array(
        [[sx * width / 2, sy * height / 2, z] for sx in (-1, 1) for sy in (-1, 1) for z in (0, KNOB_TOP)]
    )
    seen = (corners @ panel.pose[:3, :3].T + middle - place) @ axes
    spread = np.abs(seen[:, :2] / seen[:, 2:]).max(0)
    half = max(spread[1], spread[0] / aspect) / (1 - 2 * _MARGIN)
    _camera(spec, EYE, place + np.array(look.camera), axes, 2 * math.degrees(math.atan(half)))
    eye, target = np.array([1.25, 0.80, 1.15]), np.array([0.22, 0.0, 0.28])
    back = (eye - target) / np.linalg.norm(eye - target)
    right = np.cross([0, 0, 1], back)
    right /= np.linalg.norm(right)
    _camera(spec, _FILM, eye, np.array([right, np.cross(back, right), back]).T, 42.0)


def _camera(spec: mujoco.MjSpec, name: str, place: NDArray[np.float64], axes: NDArray[np.float64], fovy: float) -> None:
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(axes).ravel())
    spec.worldbody.add_camera(name=name, pos=place, quat=quaternion, fovy=fovy)
