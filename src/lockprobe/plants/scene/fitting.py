"""A joint on the panel: where its handle is at which fraction of its travel, and what room it takes.

All is in the frame of the panel: x to the right and y up as one sees it, the origin in the middle of the board.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lockprobe.lockbox.box import JointKind

__all__ = [
    "BAR",
    "KNOB_RADIUS",
    "KNOB_TOP",
    "LEVER",
    "LEVER_HALF_WIDTH",
    "SLIDE",
    "SWING",
    "WAY_RADIUS",
    "Fitting",
    "fitting_choices",
]

KNOB_RADIUS = 0.015
"""Of every handle, metres."""

KNOB_TOP = 0.05
"""Height of every handle's top above the board, metres."""

SLIDE = 0.08
"""Travel of a slider, metres."""

LEVER, SWING = 0.06, 1.4
"""From a lever's pivot to its handle, metres, and its travel, radians."""

LEVER_HALF_WIDTH = 0.009

BAR = (0.026, 0.019)
"""Half the sides of the bar under a slider's handle, along its way and across, metres."""

WAY_RADIUS = 0.0215
"""Of the mark at either end of a handle's way, metres."""

_SAMPLES = 9


@dataclass(frozen=True, slots=True, kw_only=True)
class Fitting:
    """One joint as it is fitted to the panel.

    Attributes:
        kind: Slides or turns.
        origin: Of a slider, where its handle is at position 0; of a lever, its pivot. Metres.
        direction: In which a slider slides, or in which a lever points at position 0; radians from the panel's x.
        travel: From position 0 to 1: metres, or radians (anticlockwise as one sees the panel).
        reach: From pivot to handle, metres; 0 for a slider.
    """

    kind: JointKind
    origin: tuple[float, float]
    direction: float
    travel: float
    reach: float = 0.0

    def knob(self, fraction: float) -> NDArray[np.float64]:
        """Middle of the handle, shape (2,), metres.

        Args:
            fraction: Of the travel, 0 at position 0, 1 at position 1.
        """
        if self.kind == "prismatic":
            return np.array(self.origin) + fraction * self.travel * _unit(self.direction)
        return np.array(self.origin) + self.reach * _unit(self.direction + fraction * self.travel)

    def tangent(self, fraction: float) -> NDArray[np.float64]:
        """Direction in which the handle moves towards position 1, shape (2,), of length 1."""
        if self.kind == "prismatic":
            return _unit(self.direction)
        return _unit(self.direction + fraction * self.travel + math.pi / 2)

    @property
    def length(self) -> float:
        """Of the handle's path, metres."""
        return self.travel if self.kind == "prismatic" else self.travel * self.reach

    def path(self) -> NDArray[np.float64]:
        """Middles of the handle along its travel, shape (samples, 2), metres."""
        return np.array([self.knob(fraction) for fraction in np.linspace(0, 1, _SAMPLES)])

    def room(self) -> NDArray[np.float64]:
        """Points that bar or lever ever pass over, and the handle with them, shape (points, 2), metres."""
        path = self.path()[::2]
        if self.kind == "prismatic":
            return path
        pivot = np.array(self.origin)
        return np.concatenate([pivot + share * (path - pivot) for share in (0.0, 0.5, 1.0)])


def fitting_choices(kind: JointKind, place: tuple[float, float]) -> tuple[Fitting, ...]:
    """All fittings that are tried for a joint, the preferred ones first.

    Args:
        kind: Slides or turns.
        place: Around which the joint lies, metres.
    """
    middle = np.array(place)
    shifts = [np.array([x, y]) for x, y in _SHIFTS]
    found: list[Fitting] = []
    if kind == "prismatic":
        for shift in shifts:
            for direction in (math.pi / 2, 0.0, math.pi / 4, -math.pi / 4):
                start = middle + shift - 0.5 * SLIDE * _unit(direction)
                found.append(Fitting(kind=kind, origin=_pair(start), direction=direction, travel=SLIDE))
        return tuple(found)
    for shift in shifts:
        for mean in (math.pi / 2, -math.pi / 2, 0.0, math.pi, *(k * math.pi / 4 for k in (1, 3, -3, -1))):
            pivot = middle + shift - 0.6 * LEVER * _unit(mean)
            fitting = Fitting(kind=kind, origin=_pair(pivot), direction=mean - SWING / 2, travel=SWING, reach=LEVER)
            found.append(fitting)
    return tuple(found)


_SHIFTS = ((0.0, 0.0), (0.0, 0.03), (0.0, -0.03), (0.0, 0.06), (0.0, -0.06), (0.02, 0.0), (-0.02, 0.0))
"""How far a joint may lie from its place, metres: beside neighbours that would be in its way."""


def _unit(angle: float) -> NDArray[np.float64]:
    return np.array([math.cos(angle), math.sin(angle)])


def _pair(point: NDArray[np.float64]) -> tuple[float, float]:
    return (round(float(point[0]), 6), round(float(point[1]), 6))
