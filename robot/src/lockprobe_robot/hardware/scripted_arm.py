"""A scripted arm without a body, for rehearsals and tests: it tracks targets exactly, and a symbolic box resists it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lockprobe.boxes.box import Configuration, Lockbox
from lockprobe_robot.arm.guarded_move import HandlePath
from lockprobe_robot.arm.protocol import Vector

_GRIP = 0.012
"""Distance from a handle within which the hand holds it, metres."""

_GIVE = 0.15
"""Share of its way that a locked handle gives way."""

_HELD, _LOOSE = 25.0, 3.0
"""Newtons against the drag of a locked and of a free handle."""

_WEIGHT = np.array([0.0, 0.0, -6.0])
_HOME = np.array([0.3, 0.0, 0.5])


class ScriptedArm:
    """A kinematic arm in front of a symbolic box.

    Args:
        box: The box, in its initial configuration.
        path: Function from joint (index in panel order) and present position to the handle's path.

    Attributes:
        configuration: Where the joints of the box are.
        time: Seconds that its commands took.
    """

    period = 0.02

    def __init__(self, box: Lockbox, path: Callable[[int, bool], HandlePath]) -> None:
        self._box = box
        self._paths = [(path(joint, False), path(joint, True)) for joint in range(len(box.joints))]
        self.configuration: Configuration = box.initial
        self._at, self.time = _HOME, 0.0
        self._held: tuple[int, HandlePath, bool, Configuration] | None = None
        self._felt = np.zeros(3)

    def home(self) -> None:
        """Jump to the homing pose, holding nothing."""
        self._held, self._at, self.time = None, _HOME, self.time + 1.0

    def reach(self, position: Vector, axis: Vector) -> None:
        """Jump to a pose, holding nothing."""
        self._held, self._at, self.time = None, np.array(position), self.time + 1.0

    def follow(self, position: Vector, velocity: Vector, *, stiffness: float) -> None:
        """Move to the target at the end of the period, as far as the held handle allows."""
        point = np.asarray(position + self.period * velocity)
        self.time += self.period
        self._felt = np.zeros(3)
        for joint, at in enumerate(self.configuration if self._held is None else ()):
            path = self._paths[joint][at]
            if np.linalg.norm(path.points[0] - point) < _GRIP:
                self._held = joint, path, self._box.may_move(self.configuration, joint), self.configuration
                break
        self._at = point
        if self._held is None:
            return
        joint, path, free, before = self._held
        travelled = path.travelled(point)
        stuck = not free and travelled > _GIVE * path.length
        along, direction = path.at(_GIVE * path.length if stuck else travelled)
        if float((along - point) @ path.axis) > _GRIP:
            self._held = None  # it rose from the handle
            return
        self._felt = -(_HELD if stuck else _LOOSE) * direction if travelled > 0 else np.zeros(3)
        if stuck:
            self._at = np.asarray(along)
        elif free and travelled > 0.5 * path.length and self.configuration == before:
            self.configuration = self._box.attempt(self.configuration, joint)[0]

    def position(self) -> Vector:
        """Position of the tool, metres."""
        return self._at.copy()

    def force(self) -> Vector:
        """Force on the hand over the last period, newtons."""
        return np.asarray(_WEIGHT + self._felt)

    def stop(self) -> None:
        """Do nothing: the arm moves only during commands."""
