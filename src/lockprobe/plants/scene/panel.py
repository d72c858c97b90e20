"""A board on which the joints of a box have room, or the reason why there is none.

Where joints lie is the box's; how a slider is turned and where a lever points is found by search, so that a hand can
take every handle in every configuration, nothing runs into anything, and every label can be read.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lockprobe.errors import BadValue
from lockprobe.lockbox.box import Joint, Lockbox
from lockprobe.plants.scene.fitting import BAR, KNOB_RADIUS, KNOB_TOP, WAY_RADIUS, Fitting, fitting_choices
from lockprobe.plants.scene.placement import CAMERA_DISTANCE, camera_angle, panel_pose

__all__ = ["Panel", "fit_panel"]

_CLEARANCE = 0.074
"""From the middle of a handle to the middle of any other, whatever the configuration, metres: a hand goes between."""

_ROOM = 0.042
"""Between points that the parts of two joints pass over, metres."""

_MARGIN = 0.034
"""Between those and the board's edge, metres."""

_SIZES = tuple((width, height) for height in (0.28, 0.34, 0.40) for width in (0.36, 0.44, 0.56, 0.68, 0.80, 0.88))
_SPACING = 0.135
"""How far apart joints would best lie, metres."""

_NEAREST = 0.05
"""Joints whose places are nearer to each other are not tried, metres."""

_LETTERS, _ASPECT = (0.068, 0.06, 0.052), 1.33
"""Heights of letters that are tried, as a share of the board's width, or of a picture's width beside its height."""

_OWN = 1.3
"""How many times as far from any other joint as from its own a label is at least."""

_PATIENCE = 4000
_NEAR, _FAR = 0.30, 0.72


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Panel:
    """A board and what is on it.

    Attributes:
        size: Width and height, metres.
        tilt: From lying flat, towards whoever stands before it, radians.
        depth: Of the case behind the board, metres.
        fittings: In panel order.
        labels: Where the label of each joint stands, shape (joints, 2), metres in the frame of the panel.
        letter: Height of a label's capital letter, metres.
        pose: Of the panel in the world, shape (4, 4), metres.
    """

    size: tuple[float, float]
    tilt: float
    depth: float
    fittings: tuple[Fitting, ...]
    labels: NDArray[np.float64]
    letter: float
    pose: NDArray[np.float64]

    @property
    def handles(self) -> NDArray[np.float64]:
        """Top of each joint's handle at position 0 and at 1, shape (joints, 2, 3), metres in the panel's frame."""
        return np.array([[[*f.knob(fraction), KNOB_TOP] for fraction in (0.0, 1.0)] for f in self.fittings])


def fit_panel(box: Lockbox, *, tilt: float = 20.0, depth: float = 0.06) -> Panel:
    """A panel for a box; the same for the same places, kinds, tilt and depth.

    Args:
        box: Its joints' kinds and places are used.
        tilt: Degrees from lying flat.
        depth: Of the case, metres.

    Raises:
        BadValue: If joints lie so near to each other that no board within reach has room for them.
    """
    size, fittings, labels, letter = _laid_out(box.joints, round(camera_angle(math.radians(tilt)), 3))
    pose = panel_pose(size, math.radians(tilt), depth)
    panel = Panel(
        size=size,
        tilt=math.radians(tilt),
        depth=depth,
        fittings=fittings,
        labels=np.array(labels),
        letter=letter,
        pose=pose,
    )
    tops = panel.handles.reshape(-1, 3) @ pose[:3, :3].T + pose[:3, 3]
    away = np.hypot(tops[:, 0], tops[:, 1])
    if away.max() > _FAR or away.min() < _NEAR:
        raise BadValue(
            "tilt", tilt, f"one at which the handles of {box.name} are {_NEAR} to {_FAR} m from the robot's base"
        )
    return panel


@lru_cache(maxsize=64)
def _laid_out(
    joints: tuple[Joint, ...], angle: float
) -> tuple[tuple[float, float], tuple[Fitting, ...], tuple[tuple[float, float], ...], float]:
    """Board, fittings, labels and the height of a letter."""
    places = np.array([joint.place for joint in joints])

    def regret(size: tuple[float, float]) -> float:
        near = _apart(places * size)
        return 20 * max(0.0, _SPACING - near) + size[0] * size[1]

    for size in sorted((size for size in _SIZES if _apart(places * size) > _NEAREST), key=regret):
        where = [tuple((place - 0.5) * size) for place in places]
        choices = [
            [f for f in fitting_choices(joint.kind, (float(x), float(y))) if _inside(f, size)]
            for joint, (x, y) in zip(joints, where, strict=True)
        ]
        fittings = _compatible(choices)
        if fittings is None:
            continue
        for share in _LETTERS:
            letter = share * max(size[0], _ASPECT * size[1])
            labels = _labelled(fittings, size, letter, angle)
            if labels is not None:
                return size, fittings, labels, letter
    widest = max(_SIZES)
    raise BadValue(
        "places of the joints",
        [joint.place for joint in joints],
        f"places so far apart that a hand goes between any two handles ({_CLEARANCE * 1000:.0f} mm from middle to "
        f"middle in every configuration) on a board of at most {widest[0]} by {widest[1]} m",
    )


def _apart(places: NDArray[np.float64]) -> float:
    between = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1))
    return float(between[~np.eye(len(places), dtype=bool)].min())


def _inside(fitting: Fitting, size: tuple[float, float]) -> bool:
    return bool((np.abs(fitting.room()) <= np.array(size) / 2 - _MARGIN).all())


def _nearest(first: NDArray[np.float64], second: NDArray[np.float64]) -> NDArray[np.float64]:
    """Least distance between every cloud of points and every other, shapes (a, points, 2), (b, points, 2) -> (a, b)."""
    flat, other = first.reshape(-1, 2), second.reshape(-1, 2)
    squared = (flat**2).sum(1)[:, None] + (other**2).sum(1) - 2 * flat @ other.T
    least = squared.reshape(len(first), first.shape[1], len(second), -1).min((1, 3))
    distances: NDArray[np.float64] = np.sqrt(np.maximum(least, 0))
    return distances


def _compatible(choices: Sequence[Sequence[Fitting]]) -> tuple[Fitting, ...] | None:
    """One fitting of each joint's choices such that all have room, or None; depth-first, preferred ones first."""
    count = len(choices)
    if not all(choices):
        return None
    paths = [np.array([f.path() for f in options]) for options in choices]
    rooms = [np.array([f.room() for f in options]) for options in choices]
    fits = {
        (i, j): (_nearest(paths[i], paths[j]) >= _CLEARANCE) & (_nearest(rooms[i], rooms[j]) >= _ROOM)
        for i in range(count)
        for j in range(i)
    }
    taken: list[int] = []
    patience = _PATIENCE

    def place(i: int) -> bool:
        nonlocal patience
        if i == count:
            return True
        patience -= 1
        for option in range(len(choices[i])):
            if patience > 0 and all(fits[i, j][option, other] for j, other in enumerate(taken)):
                taken.append(option)
                if place(i + 1):
                    return True
                taken.pop()
        return False

    return tuple(options[option] for options, option in zip(choices, taken, strict=True)) if place(0) else None


def _labelled(
    fittings: Sequence[Fitting], size: tuple[float, float], letter: float, angle: float
) -> tuple[tuple[float, float], ...] | None:
    """A place for each label: near its own joint, nearer than any other joint's, never under a part or behind it."""
    covered = [_covered(f, angle) for f in fittings]
    rooms = [f.room() for f in fittings]
    half = np.array(size) / 2 - 0.66 * letter
    free = 0.6 * letter + 0.002
    middles = [float(fitting.path()[:, 0].mean()) for fitting in fittings]
    options: list[list[tuple[float, float]]] = []
    for i, fitting in enumerate(fittings):
        scored = []
        points = _around(fitting, letter)
        points = points[(np.abs(points) <= half).all(1)]
        free_of, gaps = (_gaps(points, clouds) for clouds in (covered, rooms))
        for point, gap in zip(points[free_of.min(0) >= free], gaps[:, free_of.min(0) >= free].T, strict=True):
            others = min((float(other) for k, other in enumerate(gap) if k != i), default=1.0)
            if others >= _OWN * gap[i]:
                aside = abs(float(point[0] - middles[i])) + (0.01 if point[1] < 0 else 0.0)
                worth = 0.25 * min(others, 0.12) - float(gap[i]) - 0.5 * aside
                scored.append((-worth, (float(point[0]), float(point[1]))))
        options.append(_spread([point for _, point in sorted(scored)], 0.25 * letter))
    taken: list[tuple[float, float]] = []
    patience = _PATIENCE

    def place(i: int) -> bool:
        nonlocal patience
        if i == len(options):
            return True
        for point in options[i]:
            patience -= 1
            if patience > 0 and all(math.dist(point, other) > 1.5 * letter for other in taken):
                taken.append(point)
                if place(i + 1):
                    return True
                taken.pop()
        return False

    return tuple(taken) if place(0) else None


def _gaps(points: NDArray[np.float64], clouds: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """From every cloud to every point, shape (clouds, points), metres."""
    return np.array([_nearest(points[:, None], cloud[None])[:, 0] for cloud in clouds])


def _spread(points: Sequence[tuple[float, float]], apart: float) -> list[tuple[float, float]]:
    """The first of every few points that lie close together."""
    kept: list[tuple[float, float]] = []
    for point in points:
        if all(math.dist(point, other) >= apart for other in kept):
            kept.append(point)
    return kept


def _covered(fitting: Fitting, angle: float) -> NDArray[np.float64]:
    """The outline of what a joint ever covers, and of what its handle hides from the camera."""
    path = fitting.path()
    ring = np.array([[math.cos(turn), math.sin(turn)] for turn in np.arange(12) * math.pi / 6])
    eye, up = CAMERA_DISTANCE * np.array([0, math.sin(angle)]), CAMERA_DISTANCE * math.cos(angle)
    parts = [fitting.room(), *(path + WAY_RADIUS * point for point in ring)]
    for height in np.linspace(0, KNOB_TOP, 4)[1:]:
        hidden = path + (path - eye) * height / (up - height)
        parts += [hidden + 1.1 * KNOB_RADIUS * point for point in ring]
    if fitting.kind == "prismatic":
        along, across = fitting.tangent(0), np.array([-fitting.tangent(0)[1], fitting.tangent(0)[0]])
        parts += [path + a * BAR[0] * along + b * BAR[1] * across for a in (-1, 1) for b in (-1, 0, 1)]
    else:
        parts += [np.array(fitting.origin) + 0.017 * ring]
    return np.concatenate(parts)


def _around(fitting: Fitting, letter: float) -> NDArray[np.float64]:
    """Points around a joint where its label might stand, shape (points, 2)."""
    room = fitting.room()
    middle = (room.min(0) + room.max(0)) / 2
    turns = np.arange(16) * math.pi / 8
    rings = 0.6 * letter + np.array([0.018, 0.026, 0.034, 0.044, 0.056, 0.07, 0.085])
    ways = (rings[:, None, None] * np.array([np.cos(turns), np.sin(turns)]).T).reshape(-1, 2)
    return np.concatenate([centre + ways for centre in (middle, room[0], room[-1], np.array(fitting.origin))])
