"""The interface of force-torque sensors for hardware arms: an injected reader, with a check for stale readings."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import PlantFault
from lockprobe_robot.arm.protocol import Vector
from lockprobe_robot.hardware.driver_call import call_driver

OLDEST = 0.020
"""Age up to which a reading is used, seconds."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class WrenchReading:
    """One reading of a force-torque sensor.

    Attributes:
        force: Force of the environment and of gravity on the hand, in the sensor's frame, newtons, shape (3,).
        age: Age of the reading, seconds.
    """

    force: Vector
    age: float


class WrenchReader(Protocol):
    """The interface of a sensor, for example over UDP. A thread of the reader keeps the latest reading."""

    def read(self) -> WrenchReading:
        """The latest reading. Any exception counts as a fault of the sensor."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FreshWrench:
    """A sensor at the flange that refuses stale readings.

    Attributes:
        reader: The sensor.
        oldest: Largest age of a usable reading, seconds.
        turn: Rotation of the sensor in the frame of the flange, shape (3, 3).
    """

    reader: WrenchReader
    oldest: float = OLDEST
    turn: NDArray[np.float64] = field(default_factory=lambda: np.eye(3))

    def force(self, flange: NDArray[np.float64]) -> Vector:
        """The force in the frame of the arm's base, newtons.

        Args:
            flange: Orientation of the flange in that frame, shape (3, 3).

        Raises:
            PlantFault: If the reading is too old, invalid or missing.
        """
        reading = call_driver("the wrench reader", lambda: self.reader.read())  # noqa: PLW0108 - it may lack the method
        if not 0 <= reading.age <= self.oldest:
            raise PlantFault(f"the wrench is {1000 * reading.age:.0f} ms old, at most {1000 * self.oldest:.0f} ms")
        force = np.asarray(reading.force, dtype=np.float64)
        if force.shape != (3,) or not np.isfinite(force).all():
            raise PlantFault(f"the wrench reader gave {force.tolist()}, expected three numbers")
        return np.asarray(flange @ self.turn @ force)
