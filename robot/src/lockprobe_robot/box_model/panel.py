"""The layout of the panel: board size, direction of each joint, positions of labels, and the panel's pose.

The box gives the places of its joints. A search finds the direction of every slider and lever so that a hand can grip
each handle in every configuration, no parts collide, and every label is readable.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.box import Joint, Lockbox
from lockprobe.foundation.errors import BadValue
from lockprobe_robot.arm.guarded_move import HandlePath
from lockprobe_robot.box_model.mounted_joint import (
    BAR,
    KNOB_RADIUS,
    KNOB_TOP,
    WAY_RADIUS,
    MountedJoint,
    mounting_choices,
)

_CLEARANCE = 0.074
"""Least distance between the middles of two handles in any configuration, metres: a hand fits between them."""

_ROOM = 0.042
"""Least distance between the areas that the parts of two joints cover, metres."""

_MARGIN = 0.034
"""Least distance between such an area and the board's edge, metres."""

_SIZES = tuple((width, height) for height in (0.28, 0.34, 0.40) for width in (0.36, 0.44, 0.56, 0.68, 0.80, 0.88))
_SPACING = 0.135
"""Preferred distance between joints, metres."""

_NEAREST = 0.05
"""Boards on which two joints would be nearer than this are not tried, metres."""

_LETTERS, _ASPECT = (0.068, 0.06, 0.052), 1.33
"""Heights of letters to try, as a share of the board's width, or of its height times the aspect of a picture."""

_OWN = 1.3
"""Least ratio of a label's distance to any other joint and to the joint that it names."""

_POINTS = 33
"""Number of points on the path of a handle."""

_PATIENCE = 100_000
"""Options that a search tries at most."""

_T = TypeVar("_T")

_NEAR, _FAR = 0.30, 0.72


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PanelLayout:
    """A board with the positions of joints and labels.

    Attributes:
        size: Width and height, metres.
        mounted_joints: The joints in panel order.
        labels: Position of each joint's label, shape (joints, 2), metres in the frame of the panel.
        letter: Height of a label's capital letter, metres.
        tilt: Angle from lying flat, towards the robot, radians.
        depth: Depth of the case behind the board, metres.
        pose: Pose of the panel in the world, shape (4, 4), metres.
    """

    size: tuple[float, float]
    mounted_joints: tuple[MountedJoint, ...]
    labels: NDArray[np.float64]
    letter: float
    tilt: float = 0.0
    depth: float = 0.0
    pose: NDArray[np.float64] = field(default_factory=partial(np.eye, 4))

    @property
    def handles(self) -> NDArray[np.float64]:
        """Top of each joint's handle at position 0 and at 1, shape (joints, 2, 3), metres in the panel's frame."""
        return np.array([[[*f.knob(fraction), KNOB_TOP] for fraction in (0.0, 1.0)] for f in self.mounted_joints])

    def handle_path(self, joint: int, position: bool) -> HandlePath:
        """The path of a handle, by index in panel order, from its present position to the other, in the world."""
        mounted = self.mounted_joints[joint]
        fractions = np.linspace(1, 0, _POINTS) if position else np.linspace(0, 1, _POINTS)
        tops = np.array([[*mounted.knob(float(fraction)), KNOB_TOP] for fraction in fractions])
        return HandlePath(points=self.in_world(tops), axis=-self.pose[:3, 2])

    def in_world(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Transform points from the panel's frame to the world, the same shape, metres."""
        return np.asarray(points @ self.pose[:3, :3].T + self.pose[:3, 3])


def lay_out_panel(box: Lockbox, *, tilt: float = 20.0, depth: float = 0.06) -> PanelLayout:
    """Lay out a panel for a box. Equal places, kinds, tilt and depth give an equal layout.

    ``tilt`` is degrees from lying flat, ``depth`` that of the case, metres.

    Raises:
        BadValue: If no board within reach has room for the joints, because they are too close together.
    """
    lean = math.radians(tilt)
    flat = _laid_out(box.joints, round(camera_angle(lean), 3))
    # in front of the robot, the case above the ground; a steeper panel stands higher, because the arm cannot bend its
    # hand under a low, steep panel
    sine, cosine = math.sin(lean), math.cos(lean)
    lowest = 0.5 * flat.size[1] * sine + depth * cosine
    pose = np.eye(4)
    pose[:3, :3] = np.array([(0, -1, 0), (cosine, 0, sine), (-sine, 0, cosine)]).T
    pose[:3, 3] = (0.5, 0, max(_HEIGHT, lowest + 0.03, _HEIGHT + _RAISED * (lean - math.radians(20))))
    panel = replace(flat, tilt=lean, depth=depth, pose=pose)
    tops = panel.in_world(panel.handles.reshape(-1, 3))
    away = np.hypot(tops[:, 0], tops[:, 1])
    if away.max() > _FAR or away.min() < _NEAR:
        raise BadValue(
            "tilt", tilt, f"one at which the handles of {box.name} are {_NEAR} to {_FAR} m from the robot's base"
        )
    return panel


@lru_cache(maxsize=64)
def _laid_out(joints: tuple[Joint, ...], angle: float) -> PanelLayout:
    """A board of joints that lies flat, without a case, for a camera at an angle to its normal."""
    places = np.array([joint.place for joint in joints])

    def regret(size: tuple[float, float]) -> float:
        near = _apart(places * size)
        return 20 * max(0.0, _SPACING - near) + size[0] * size[1]

    for size in sorted((size for size in _SIZES if _apart(places * size) > _NEAREST), key=regret):
        where = [tuple((place - 0.5) * size) for place in places]
        half = np.array(size) / 2 - _MARGIN
        choices = [
            [f for f in mounting_choices(joint.kind, (float(x), float(y))) if (np.abs(f.room()) <= half).all()]
            for joint, (x, y) in zip(joints, where, strict=True)
        ]
        mounted_joints = _compatible(choices)
        if mounted_joints is None:
            continue
        for share in _LETTERS:
            letter = share * max(size[0], _ASPECT * size[1])
            labels = _labelled(mounted_joints, size, letter, angle)
            if labels is not None:
                return PanelLayout(size=size, mounted_joints=mounted_joints, labels=np.array(labels), letter=letter)
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


def _nearest(first: NDArray[np.float64], second: NDArray[np.float64]) -> NDArray[np.float64]:
    """Least distance between each pair of point clouds, shapes (a, points, 2), (b, points, 2) -> (a, b)."""
    flat, other = first.reshape(-1, 2), second.reshape(-1, 2)
    squared = (flat**2).sum(1)[:, None] + (other**2).sum(1) - 2 * flat @ other.T
    least = squared.reshape(len(first), first.shape[1], len(second), -1).min((1, 3))
    distances: NDArray[np.float64] = np.sqrt(np.maximum(least, 0))
    return distances


def _compatible(choices: Sequence[Sequence[MountedJoint]]) -> tuple[MountedJoint, ...] | None:
    """A mounting for each joint without collisions, or None; by depth-first search, preferred mountings first."""
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
    found = _chosen(
        [range(len(options)) for options in choices],
        lambda taken, option: all(fits[len(taken), j][option, other] for j, other in enumerate(taken)),
    )
    return None if found is None else tuple(options[option] for options, option in zip(choices, found, strict=True))


def _chosen(options: Sequence[Sequence[_T]], fits: Callable[[list[_T], _T], bool]) -> tuple[_T, ...] | None:
    """An option of each so that every one fits those taken before it, earlier ones preferred; None if there is none.

    By depth-first search, which is given up after a number of tries.
    """
    taken: list[_T] = []
    patience = _PATIENCE

    def fill() -> bool:
        nonlocal patience
        if len(taken) == len(options):
            return True
        for option in options[len(taken)]:
            patience -= 1
            if patience > 0 and fits(taken, option):
                taken.append(option)
                if fill():
                    return True
                taken.pop()
        return False

    return tuple(taken) if fill() else None


def _labelled(
    mounted_joints: Sequence[MountedJoint], size: tuple[float, float], letter: float, angle: float
) -> tuple[tuple[float, float], ...] | None:
    """A position for each label: near its joint, and never under or hidden by a part."""
    covered = [covered_area(f, angle) for f in mounted_joints]
    rooms = [f.room() for f in mounted_joints]
    half = np.array(size) / 2 - 0.66 * letter
    free = 0.6 * letter + 0.002
    middles = [float(mounted.path()[:, 0].mean()) for mounted in mounted_joints]
    turns = np.arange(16) * math.pi / 8
    rings = 0.6 * letter + np.array([0.018, 0.026, 0.034, 0.044, 0.056, 0.07, 0.085])
    ways = (rings[:, None, None] * np.array([np.cos(turns), np.sin(turns)]).T).reshape(-1, 2)
    options: list[list[tuple[float, float]]] = []
    for i, mounted in enumerate(mounted_joints):
        scored = []
        room = rooms[i]
        near = ((room.min(0) + room.max(0)) / 2, room[0], room[-1], np.array(mounted.origin))
        points = np.concatenate([centre + ways for centre in near])
        points = points[(np.abs(points) <= half).all(1)]
        free_of, gaps = (
            np.array([_nearest(points[:, None], cloud[None])[:, 0] for cloud in clouds]) for clouds in (covered, rooms)
        )
        for point, gap in zip(points[free_of.min(0) >= free], gaps[:, free_of.min(0) >= free].T, strict=True):
            others = min((float(other) for k, other in enumerate(gap) if k != i), default=1.0)
            if others >= _OWN * gap[i]:
                aside = abs(float(point[0] - middles[i])) + (0.01 if point[1] < 0 else 0.0)
                worth = 0.25 * min(others, 0.12) - float(gap[i]) - 0.5 * aside
                scored.append((-worth, (float(point[0]), float(point[1]))))
        kept: list[tuple[float, float]] = []
        for _, place in sorted(scored):
            if all(math.dist(place, other) >= 0.25 * letter for other in kept):
                kept.append(place)
        options.append(kept)
    return _chosen(options, lambda taken, point: all(math.dist(point, other) > 1.5 * letter for other in taken))


def covered_area(mounted: MountedJoint, angle: float) -> NDArray[np.float64]:
    """Points of the swept area of a joint, and of the area that its handle hides from the camera.

    ``angle`` is that between the panel's normal and the direction to the camera, radians. Shape (points, 2), metres in
    the frame of the panel.
    """
    path = mounted.path()
    ring = np.array([[math.cos(turn), math.sin(turn)] for turn in np.arange(12) * math.pi / 6])
    eye, up = CAMERA_DISTANCE * np.array([0, math.sin(angle)]), CAMERA_DISTANCE * math.cos(angle)
    parts = [mounted.room(), *(path + WAY_RADIUS * point for point in ring)]
    for height in np.linspace(0, KNOB_TOP, 4)[1:]:
        hidden = path + (path - eye) * height / (up - height)
        parts += [hidden + 1.1 * KNOB_RADIUS * point for point in ring]
    if mounted.kind == "prismatic":
        cosine, sine = math.cos(mounted.direction), math.sin(mounted.direction)
        along, across = np.array([cosine, sine]), np.array([-sine, cosine])
        parts += [path + a * BAR[0] * along + b * BAR[1] * across for a in (-1, 1) for b in (-1, 0, 1)]
    else:
        parts += [np.array(mounted.origin) + 0.017 * ring]
    return np.concatenate(parts)


CAMERA_DISTANCE = 0.72
"""From the middle of the board to the camera, metres."""

_CAMERA_LAG, _CAMERA_LEAN = math.radians(12), math.radians(40)

_HEIGHT, _RAISED = 0.16, 0.63
"""Height of the middle of a board tilted by 20 degrees or less, and increase for every further radian, metres."""


def camera_angle(tilt: float) -> float:
    """Angle between the panel's normal and the direction to the camera, radians, positive if the camera is above.

    The camera leans towards the robot like the panel, less ``_CAMERA_LAG``, but only as far as an arm at home does not
    block its view.
    """
    return tilt - min(max(tilt - _CAMERA_LAG, 0.0), _CAMERA_LEAN)
