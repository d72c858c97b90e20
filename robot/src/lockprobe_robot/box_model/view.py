"""The place of the plant's camera: it sees the whole board with a margin, and never an arm at home."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lockprobe_robot.box_model.mounted_joint import KNOB_TOP
from lockprobe_robot.box_model.panel import CAMERA_DISTANCE, PanelLayout, camera_angle
from lockprobe_robot.twin_settings import Viewpoint

_MARGIN = 0.08
"""Margin around the board in pictures, as a share of their width or height."""

_ASIDE = math.radians(28)
"""Angle by which the oblique viewpoint is turned about the board's middle, towards its left side."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class View:
    """Where the plant's camera is and what it sees.

    Attributes:
        position: Metres in the world, shape (3,).
        axes: Its x (right), y (up) and z (backwards) in the world, as columns, shape (3, 3).
        half: Tangent of half the vertical field of view.
        aspect: Width by height of pictures.
    """

    position: NDArray[np.float64]
    axes: NDArray[np.float64]
    half: float
    aspect: float

    @property
    def fovy(self) -> float:
        """Vertical field of view, degrees."""
        return 2 * math.degrees(math.atan(self.half))

    def project(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points of the world, shape (..., 3), in the picture, shape (..., 2): -1 to 1 from left to right, and up."""
        seen = (points - self.position) @ self.axes
        flat: NDArray[np.float64] = seen[..., :2] / (-seen[..., 2:] * np.array([self.half * self.aspect, self.half]))
        return flat


def view_of(panel: PanelLayout, viewpoint: Viewpoint, offset: tuple[float, float, float], *, aspect: float) -> View:
    """The view of a panel from a viewpoint, with an offset in the world, metres, for pictures of an aspect."""
    middle = panel.pose[:3, 3]
    lean = panel.tilt - camera_angle(panel.tilt)
    away = np.array([-math.sin(lean), 0, math.cos(lean)])
    axes = np.array([[0, -1, 0], [math.cos(lean), 0, math.sin(lean)], away]).T
    if viewpoint == "oblique":
        sine, cosine = math.sin(_ASIDE), math.cos(_ASIDE)
        axes = axes @ np.array([[cosine, 0, -sine], [0, 1, 0], [sine, 0, cosine]])
        away = axes[:, 2]
    position = middle + CAMERA_DISTANCE * away
    width, height = panel.size
    corners = np.array(
        [[sx * width / 2, sy * height / 2, z] for sx in (-1, 1) for sy in (-1, 1) for z in (0, KNOB_TOP)]
    )
    seen = (panel.in_world(corners) - position) @ axes
    spread = np.abs(seen[:, :2] / seen[:, 2:]).max(0)
    half = max(spread[1], spread[0] / aspect) / (1 - 2 * _MARGIN)
    return View(position=position + np.array(offset), axes=axes, half=half, aspect=aspect)
