"""Places for four AprilTags on a panel's board, and a checksum of the board that they identify.

The tags carry the numbers 0 to 3, clockwise from the upper left.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue
from lockprobe_robot.box_model.panel import PanelLayout, camera_angle, covered_area

TAG_SIDE = 0.04
"""Side of a tag's black square, metres."""

QUIET_ZONE = 0.125
"""Width of the white border around a tag, as a share of its side: one of its eight cells."""

_GAP = 0.003
"""Least distance of the white border from the board's edge and from every part, metres."""

_GRID = 0.004
"""Distance of the places that are tried, metres."""

_LETTER = 0.55
"""Half the width of a label, in heights of a letter."""

_QUADRANTS = ((-1, 1), (1, 1), (1, -1), (-1, -1))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TagLayout:
    """The positions of the tags on a board.

    Attributes:
        side: Side of the black square, metres.
        middles: Middle of each tag by its number, shape (tags, 2), metres in the frame of the panel.
    """

    side: float
    middles: NDArray[np.float64]

    @property
    def corners(self) -> NDArray[np.float64]:
        """Corners of each black square: upper left, upper right, lower right, lower left.

        Shape (tags, 4, 3), metres in the frame of the panel; the upper edge of a tag points along y.
        """
        square = 0.5 * self.side * np.array(_QUADRANTS, dtype=np.float64)
        flat = self.middles[:, None] + square
        return np.concatenate([flat, np.zeros((*flat.shape[:2], 1))], axis=-1)


def place_tags(panel: PanelLayout, side: float = TAG_SIDE) -> TagLayout:
    """Place one tag in each quarter of the board, as near to its corner as parts, labels and lines of sight allow.

    Args:
        panel: The layout of joints and labels.
        side: Side of a tag's black square, metres.

    Raises:
        BadValue: If a quarter of the board has no room for a tag.
    """
    half = (0.5 + QUIET_ZONE) * side
    board = np.array(panel.size) / 2
    reach = np.floor((board - half - _GAP) / _GRID) * _GRID
    across, up = (np.arange(-end, end + 1e-9, _GRID) for end in reach)
    places = np.stack(np.meshgrid(across, up), axis=-1).reshape(-1, 2)
    angle = camera_angle(panel.tilt)
    parts = np.concatenate([covered_area(mounted, angle) for mounted in panel.mounted_joints])

    def free(place: NDArray[np.float64]) -> bool:
        return _gap(place, parts) > half + _GAP and _gap(place, panel.labels) > half + _LETTER * panel.letter

    middles = []
    for quadrant in _QUADRANTS:
        inside = places[(places * quadrant > 0).all(1)]
        nearest = inside[np.abs(inside - board * quadrant).sum(1).argsort(kind="stable")]
        middle = next((place for place in nearest if free(place)), None)
        if middle is None:
            raise BadValue("tags", f"{1000 * side:g} mm", "smaller ones: a quarter of the board has no room for these")
        middles.append(middle.round(3))
    return TagLayout(side=side, middles=np.array(middles))


def resized(tags: TagLayout, side: float) -> TagLayout:
    """The tags as printed: with another side length in metres and the same centres."""
    return replace(tags, side=side)


def _gap(place: NDArray[np.float64], points: NDArray[np.float64]) -> float:
    """Chebyshev distance of a place from the nearest point."""
    return float(np.abs(points - place).max(1).min())


def board_checksum(panel: PanelLayout, tags: TagLayout) -> str:
    """A checksum of the dimensions of a board and its tags; boards with equal dimensions have equal checksums.

    Dimensions count to 0.01 mm and 0.00001 radians. Labels, tilt and interlock do not count.
    """
    drawn = {
        "size": [round(side, 5) for side in panel.size],
        "joints": [
            [joint.kind, *(round(float(x), 5) for x in (*joint.origin, joint.direction, joint.travel, joint.reach))]
            for joint in panel.mounted_joints
        ],
        "tags": [round(tags.side, 5), *(round(float(x), 5) for x in tags.middles.ravel())],
    }
    return hashlib.sha256(json.dumps(drawn, sort_keys=True).encode()).hexdigest()
