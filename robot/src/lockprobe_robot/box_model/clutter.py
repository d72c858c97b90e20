"""Small objects that lie on the board and on the ground beside it: they are only seen.

On the board they touch neither labels nor what a joint sweeps, and hide neither from the camera.
"""

from __future__ import annotations

import colorsys
import math
from typing import Final

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe_robot.box_model.panel import PanelLayout, covered_area
from lockprobe_robot.box_model.view import View
from lockprobe_robot.geom_groups import NOTHING

_RADII: Final = (0.006, 0.012)
"""Least and greatest radius of an object, metres; on the ground it is twice as large."""

_HEIGHTS: Final = (0.006, 0.018)
_GAP: Final = 0.006
"""Least distance between an object on the board and what must stay free, metres."""

_LETTER: Final = 0.8
"""Radius around a label that stays free, in heights of a letter."""

_TRIES: Final = 200
"""Places that are tried for an object on the board before it is put on the ground."""

_SOLIDS: Final = (mujoco.mjtGeom.mjGEOM_CYLINDER, mujoco.mjtGeom.mjGEOM_BOX, mujoco.mjtGeom.mjGEOM_ELLIPSOID)


def add_clutter(
    spec: mujoco.MjSpec, board: mujoco.MjsBody, panel: PanelLayout, view: View, *, count: int, luck: int
) -> None:
    """Add objects in turn on the board and on the ground. More objects are the same and further ones.

    ``luck`` is the seed of places, shapes and colours.
    """
    if not count:
        return
    rng = np.random.Generator(np.random.PCG64(luck))
    free, ground = _FreePlaces(panel, view), _GroundPlaces(panel, view)
    for number in range(count):
        size, tall, hue, full, bright, turn = rng.random(6)
        solid = _SOLIDS[int(rng.integers(len(_SOLIDS)))]
        radius = _RADII[0] + size * (_RADII[1] - _RADII[0])
        height = _HEIGHTS[0] + tall * (_HEIGHTS[1] - _HEIGHTS[0])
        tries = rng.random((_TRIES, 2))
        place = free.take(tries, radius, height) if number % 2 == 0 else None
        body = board
        if place is None:
            body, radius, height = spec.worldbody, 2 * radius, 2 * height
            place = ground.take(tries, radius)
        half = radius / math.sqrt(2) if solid == mujoco.mjtGeom.mjGEOM_BOX else radius
        flat = [half, height / 2, 0] if solid == mujoco.mjtGeom.mjGEOM_CYLINDER else [half, half, height / 2]
        body.add_geom(
            name=f"clutter-{number}",
            type=solid,
            size=flat,
            pos=[*place, height / 2],
            quat=[math.cos(math.pi * turn), 0, 0, math.sin(math.pi * turn)],
            rgba=[*colorsys.hsv_to_rgb(float(hue), 0.3 + 0.6 * float(full), 0.35 + 0.6 * float(bright)), 1],
            mass=0,
            contype=NOTHING,
            conaffinity=NOTHING,
        )


class _FreePlaces:
    """The places on the board that are still free."""

    def __init__(self, panel: PanelLayout, view: View) -> None:
        self._half = np.array(panel.size) / 2
        eye = panel.pose[:3, :3].T @ (view.position - panel.pose[:3, 3])
        self._eye, self._up = eye[:2], float(eye[2])
        angle = math.atan2(eye[1], eye[2])
        swept = np.concatenate([covered_area(mounted, angle) for mounted in panel.mounted_joints])
        self._points = np.concatenate([swept, panel.labels])
        self._radii = np.array([0.0] * len(swept) + [_LETTER * panel.letter] * len(panel.labels))

    def take(self, tries: NDArray[np.float64], radius: float, height: float) -> NDArray[np.float64] | None:
        """The first of these places, each two shares of the board, that is free, or None."""
        for place in (2 * tries - 1) * (self._half - radius - _GAP):
            # From the camera the object hides the board behind it, and a joint there would be hidden, too.
            away = (place - self._eye) * height / (self._up - height)
            hidden = place + np.linspace(0, 1, 4)[:, None] * away
            gaps = np.linalg.norm(self._points - hidden[:, None], axis=-1).min(0)
            if (gaps > self._radii + radius + _GAP).all():
                self._points = np.concatenate([self._points, hidden])
                self._radii = np.concatenate([self._radii, np.full(len(hidden), radius)])
                return np.array(place)
        return None


class _GroundPlaces:
    """The places on the ground that the camera sees beside the board."""

    def __init__(self, panel: PanelLayout, view: View) -> None:
        self._view = view
        width, height = panel.size
        corners = np.array([[x * width / 2, y * height / 2, 0] for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
        self._board = view.project(panel.in_world(corners))
        self._taken: list[tuple[NDArray[np.float64], float]] = []

    def take(self, tries: NDArray[np.float64], radius: float) -> NDArray[np.float64]:
        """The first of these places, each two shares of the picture, that is free; else the freest."""
        found = [self._place(share) for share in 2 * tries - 1]
        rooms = [self._room(place, radius) for place in found]
        best = next((i for i, room in enumerate(rooms) if room > 0), int(np.argmax(rooms)))
        self._taken.append((found[best], radius))
        return found[best]

    def _place(self, share: NDArray[np.float64]) -> NDArray[np.float64]:
        """The point of the ground that is seen there, metres."""
        view = self._view
        ray = view.axes @ np.array([share[0] * view.half * view.aspect, share[1] * view.half, -1.0])
        return np.array(view.position[:2] - ray[:2] * view.position[2] / min(ray[2], -0.1))

    def _room(self, place: NDArray[np.float64], radius: float) -> float:
        """How far an object there is from the board and the edge of the picture, as seen, and from others; metres."""
        turns = np.arange(8) * math.pi / 4
        rim = place + radius * np.array([np.cos(turns), np.sin(turns)]).T
        seen = self._view.project(np.concatenate([rim, np.zeros((8, 1))], axis=1))
        sides = np.roll(self._board, -1, axis=0) - self._board
        outwards = np.array([sides[:, 1], -sides[:, 0]]).T / np.linalg.norm(sides, axis=1)[:, None]
        beside = float(((seen[:, None] - self._board) * outwards).sum(-1).max(1).min())
        inside = float((1 - np.abs(seen)).min())
        apart = min((math.dist(place, other) - radius - far for other, far in self._taken), default=1.0)
        return min(beside, inside, apart)
