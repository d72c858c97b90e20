"""The interface of an arm for the guarded move, simulated or real."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
"""Shape (3,), in the frame of the arm's base: x forward, z up."""


class StoppableArm(Protocol):
    """A torque-controlled arm with a hand and a force sensor, commanded by a slower, supervisory loop.

    Poses refer to the tool centre point: the point in the hand that holds the top of a knob. Calls block, and another
    thread can stop the arm meanwhile. A class may add ``facts`` for the record.
    """

    @property
    def period(self) -> float:
        """Duration of one call of :meth:`follow`, seconds."""
        ...

    @property
    def time(self) -> float:
        """Seconds since a fixed moment, by the arm's clock."""
        ...

    def home(self) -> None:
        """Go to the homing pose, out of the camera's view, freely through joint space.

        Raises:
            PlantFault: If it does not arrive.
        """
        ...

    def reach(self, position: Vector, axis: Vector) -> None:
        """Go to a pose freely through joint space. The arm chooses the rotation about the axis.

        Args:
            position: Position of the tool, metres.
            axis: Direction in which the hand points, a unit vector.

        Raises:
            PlantFault: If it cannot reach the pose.
        """
        ...

    def follow(self, position: Vector, velocity: Vector, *, stiffness: float) -> None:
        """Follow a moving target for one period under Cartesian impedance, keeping the orientation.

        Args:
            position: The target at the start of the period, metres.
            velocity: The target's velocity, metres per second.
            stiffness: Translational stiffness, newtons per metre.
        """
        ...

    def position(self) -> Vector:
        """Position of the tool, metres."""
        ...

    def force(self) -> Vector:
        """Mean force on the hand over the last period, newtons, including the hand's weight."""
        ...

    def stop(self) -> None:
        """Bring the arm to rest as fast as is safe. The next command starts it again. Idempotent."""
        ...
