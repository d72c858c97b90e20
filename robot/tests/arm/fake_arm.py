"""An arm that goes exactly where it is drawn and feels what a script says."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from lockprobe_robot.arm.protocol import Vector


class FakeArm:
    """Keeps a log of what it was asked to do.

    Args:
        feel: Force on the hand, newtons, from where the tool is and the seconds for which it has been drawn.
        follows: Where the tool comes to when it is drawn to a point; left out, it comes there.
    """

    period = 0.01

    def __init__(
        self,
        feel: Callable[[Vector, float], Vector] = lambda position, time: np.zeros(3),
        follows: Callable[[Vector], Vector] = lambda point: point,
    ) -> None:
        self.log: list[str] = []
        self.drawn: list[tuple[Vector, Vector, float]] = []
        self._feel, self._follows = feel, follows
        self._at, self._time = np.zeros(3), 0.0

    @property
    def time(self) -> float:
        return self._time

    def home(self) -> None:
        self.log.append("home")
        self._time += 1.0

    def reach(self, position: Vector, axis: Vector) -> None:
        self.log.append("reach")
        self._at, self._time = np.array(position), self._time + 1.0

    def follow(self, position: Vector, velocity: Vector, *, stiffness: float) -> None:
        self.log.append("follow")
        self.drawn.append((np.array(position), np.array(velocity), stiffness))
        self._at = self._follows(position + self.period * velocity)
        self._time += self.period

    def position(self) -> Vector:
        return self._at.copy()

    def force(self) -> Vector:
        return self._feel(self._at, self._time)
