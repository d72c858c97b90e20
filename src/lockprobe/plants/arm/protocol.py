"""What a guarded move needs of an arm. A simulated arm has it, and so can a real one."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

__all__ = ["Arm", "Vector"]

Vector = NDArray[np.float64]
"""Shape (3,), in the frame of the arm's base: x forward, z up."""


class Arm(Protocol):
    """A torque-controlled arm with a hand and a force sensor, at the rate of a supervisor, not of its inner loop.

    Poses are those of the tool, the point in the hand where the top of a knob is held. Calls block.
    """

    @property
    def period(self) -> float:
        """Seconds that one call of :meth:`follow` takes."""
        ...

    @property
    def time(self) -> float:
        """Seconds since some fixed moment, by the arm's own clock."""
        ...

    def home(self) -> None:
        """Go to the homing pose, out of the camera's view, freely through joint space.

        Raises:
            PlantFault: If it does not get there.
        """
        ...

    def reach(self, position: Vector, axis: Vector) -> None:
        """Go to a pose freely through joint space; the turn about the axis is the arm's own choice.

        Args:
            position: Of the tool, metres.
            axis: Where the hand points, a unit vector.

        Raises:
            PlantFault: If it cannot get there.
        """
        ...

    def follow(self, position: Vector, velocity: Vector, *, stiffness: float) -> None:
        """Be drawn towards a moving point for one period, as if by springs; the orientation is held.

        Args:
            position: Of the point at the start of the period, metres.
            velocity: Of the point, metres per second.
            stiffness: Newtons per metre.
        """
        ...

    def position(self) -> Vector:
        """Where the tool is, metres."""
        ...

    def force(self) -> Vector:
        """The mean force on the hand over the last period, newtons; what the hand weighs is in it."""
        ...
