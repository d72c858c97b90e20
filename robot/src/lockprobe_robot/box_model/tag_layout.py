"""Places for four AprilTags on a panel's board, and a checksum of the board that they identify.

The tags carry the numbers 0 to 3, clockwise from the upper left.
"""

from __future__ import annotations

import hashlib
import json

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


def place_tags(panel: PanelLayout) -> NDArray[np.float64]:
    """Place one tag in each quarter of the board, as near to its corner as parts, labels and lines of sight allow.

    Returned is the middle of each tag by its number, shape (tags, 2), metres in the frame of the panel.

    Raises:
        BadValue: If a quarter of the board has no room for a tag.
    """
    half = (0.5 + QUIET_ZONE) * TAG_SIDE + _GAP
    board = np.array(panel.size) / 2
    reach = np.floor((board - half) / _GRID) * _GRID
    across, up = (np.arange(-end, end + 1e-9, _GRID) for end in reach)
    places = np.stack(np.meshgrid(across, up), axis=-1).reshape(-1, 2)
    parts = np.concatenate([covered_area(mounted, camera_angle(panel.tilt)) for mounted in panel.mounted_joints])

    def free(place: NDArray[np.float64]) -> bool:
        gap, label_gap = (float(np.abs(points - place).max(1).min()) for points in (parts, panel.labels))
        return gap > half and label_gap > half - _GAP + _LETTER * panel.letter

    middles = []
    for quadrant in _QUADRANTS:
        inside = places[(places * quadrant > 0).all(1)]
        nearest = inside[np.abs(inside - board * quadrant).sum(1).argsort(kind="stable")]
        middle = next((place for place in nearest if free(place)), None)
        if middle is None:
            raise BadValue("tags", f"{1000 * TAG_SIDE:g} mm", "a board with room for one in each quarter")
        middles.append(middle.round(3))
    return np.array(middles)


def tag_corners(middles: NDArray[np.float64], side: float) -> NDArray[np.float64]:
    """Corners of black squares with a side, metres: upper left, upper right, lower right, lower left.

    Shape (tags, 4, 3), metres in the frame of the panel; the upper edge of a tag points along y.
    """
    flat = middles[:, None] + 0.5 * side * np.array(_QUADRANTS, dtype=np.float64)
    return np.concatenate([flat, np.zeros((*flat.shape[:2], 1))], axis=-1)


def board_checksum(panel: PanelLayout) -> str:
    """A checksum of the dimensions of a board, to 0.01 mm; labels, tilt and interlock do not count."""
    joints = [
        [joint.kind, *(round(float(x), 5) for x in (*joint.origin, joint.direction, joint.travel, joint.reach))]
        for joint in panel.mounted_joints
    ]
    drawn = {"size": [round(side, 5) for side in panel.size], "joints": joints}
    return hashlib.sha256(json.dumps(drawn, sort_keys=True).encode()).hexdigest()
