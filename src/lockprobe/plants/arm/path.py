"""The way that a handle goes from one end of its travel to the other."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lockprobe.plants.arm.protocol import Vector

__all__ = ["Path"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Path:
    """A curve through points, measured by its length.

    Attributes:
        points: Shape (n, 3) with n > 1, metres; no two neighbours are equal.
        axis: Where a hand points that holds the handle, a unit vector of shape (3,).
    """

    points: NDArray[np.float64]
    axis: Vector
    _along: NDArray[np.float64] = field(init=False, repr=False)
    _directions: NDArray[np.float64] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        steps = np.diff(self.points, axis=0)
        lengths = np.linalg.norm(steps, axis=1)
        object.__setattr__(self, "_along", np.concatenate([[0.0], np.cumsum(lengths)]))
        object.__setattr__(self, "_directions", steps / lengths[:, None])

    @property
    def length(self) -> float:
        """Metres."""
        return float(self._along[-1])

    def at(self, distance: float) -> tuple[Vector, Vector]:
        """The point at a distance from the start, and the direction of the curve there.

        Args:
            distance: Metres; before the start and beyond the end the curve goes straight on.
        """
        last = len(self._directions) - 1
        piece = min(max(int(np.searchsorted(self._along, distance, side="right")) - 1, 0), last)
        direction = self._directions[piece]
        return self.points[piece] + (distance - self._along[piece]) * direction, direction

    def travelled(self, point: Vector) -> float:
        """How far along the curve the place nearest to a point is, metres; it may lie before or beyond the curve."""
        ahead = np.einsum("ij,ij->i", point - self.points[:-1], self._directions)
        spans = np.diff(self._along)
        inside = np.clip(ahead, 0.0, spans)
        gaps = np.linalg.norm(self.points[:-1] + inside[:, None] * self._directions - point, axis=1)
        piece = int(np.argmin(gaps))
        ends = (piece == 0 and ahead[piece] < 0) or (piece == len(spans) - 1 and ahead[piece] > spans[piece])
        return float(self._along[piece] + (ahead if ends else inside)[piece])
