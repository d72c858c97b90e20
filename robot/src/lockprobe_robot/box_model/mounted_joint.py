"""Geometry of one joint on the panel: positions of its handle, and the area that it covers.

Coordinates are in the frame of the panel: x to the right, y up as seen from the front, origin in its middle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.box import JointKind

KNOB_RADIUS = 0.015
"""Radius of every handle, metres."""

KNOB_TOP = 0.05
"""Height of every handle's top above the board, metres."""

SLIDE = 0.08
"""Travel of a slider, metres."""

LEVER, SWING = 0.06, 1.4
"""Distance of a lever's handle from its pivot, metres, and its travel, radians."""

LEVER_HALF_WIDTH = 0.009

PIVOT_RADIUS = 0.0065
"""Radius of a lever's pivot, metres."""

BAR = (0.026, 0.019)
"""Half the sides of the bar under a slider's handle, along its travel and across, metres."""

ALUMINIUM = 2700.0
"""Density of what moves, kilograms per cubic metre: a joint weighs 0.15 to 0.3 kg and has no inertia but that."""

TRACK_RADIUS = 0.007
"""Half the width of the track along which a handle travels, metres."""

WAY_RADIUS = 0.0215
"""Radius of the mark at either end of a handle's travel, metres."""

_SAMPLES = 9


@dataclass(frozen=True, slots=True, kw_only=True)
class MountedJoint:
    """One joint as it is mounted on the panel.

    Attributes:
        kind: ``prismatic`` (slides) or ``revolute`` (turns).
        origin: For a slider, the middle of its handle at position 0; for a lever, its pivot. Metres.
        direction: Direction in which a slider moves, or in which a lever points at position 0; radians
            from the panel's x.
        travel: Travel from position 0 to 1: metres, or radians (anticlockwise as seen from the front).
        reach: Distance of the handle from the pivot, metres; 0 for a slider.
    """

    kind: JointKind
    origin: tuple[float, float]
    direction: float
    travel: float
    reach: float = 0.0

    def knob(self, fraction: float) -> NDArray[np.float64]:
        """Middle of the handle at a fraction of its travel from position 0, shape (2,), metres."""
        if self.kind == "prismatic":
            return np.array(self.origin) + fraction * self.travel * _unit(self.direction)
        return np.array(self.origin) + self.reach * _unit(self.direction + fraction * self.travel)

    def path(self) -> NDArray[np.float64]:
        """Middles of the handle along its travel, shape (samples, 2), metres."""
        return np.array([self.knob(fraction) for fraction in np.linspace(0, 1, _SAMPLES)])

    def room(self) -> NDArray[np.float64]:
        """Points that cover the swept area of handle, bar and lever, shape (points, 2), metres."""
        path = self.path()[::2]
        if self.kind == "prismatic":
            return path
        pivot = np.array(self.origin)
        return np.concatenate([pivot + share * (path - pivot) for share in (0.0, 0.5, 1.0)])


def mounting_choices(kind: JointKind, place: tuple[float, float]) -> tuple[MountedJoint, ...]:
    """All ways to mount a joint at a place, metres, that the layout tries, preferred ones first."""
    middles = [np.array(place) + shift for shift in _SHIFTS]
    if kind == "prismatic":
        return tuple(
            MountedJoint(kind=kind, origin=_pair(middle - 0.5 * SLIDE * _unit(angle)), direction=angle, travel=SLIDE)
            for middle in middles
            for angle in (math.pi / 2, 0.0, math.pi / 4, -math.pi / 4)
        )
    means = (math.pi / 2, -math.pi / 2, 0.0, math.pi, *(k * math.pi / 4 for k in (1, 3, -3, -1)))
    pivots = [(mean, _pair(middle - 0.6 * LEVER * _unit(mean))) for middle in middles for mean in means]
    return tuple(
        MountedJoint(kind=kind, origin=pivot, direction=mean - SWING / 2, travel=SWING, reach=LEVER)
        for mean, pivot in pivots
    )


_SHIFTS = ((0.0, 0.0), (0.0, 0.03), (0.0, -0.03), (0.0, 0.06), (0.0, -0.06), (0.02, 0.0), (-0.02, 0.0))
"""Offsets from a joint's position that the layout tries, metres, to avoid its neighbours."""


def _unit(angle: float) -> NDArray[np.float64]:
    return np.array([math.cos(angle), math.sin(angle)])


def _pair(point: NDArray[np.float64]) -> tuple[float, float]:
    return (round(float(point[0]), 6), round(float(point[1]), 6))
