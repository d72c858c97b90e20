"""Rigid poses (SE(3)): check, mean and rotation distance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, FiniteFloat

Pose = NDArray[np.float64]
"""Shape (4, 4): rotation and position in metres of one frame in another."""

_Row = tuple[FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat]

_TOLERANCE = 1e-3
"""Largest deviation from a rotation: poses are typed and printed with a few digits."""


def is_rigid(pose: Pose) -> bool:
    """Whether a matrix of shape (4, 4) is a rigid pose, within the precision of typed numbers."""
    turn = pose[:3, :3]
    straight = np.abs(turn @ turn.T - np.eye(3)).max() < _TOLERANCE and np.linalg.det(turn) > 0
    level = np.abs(pose[3] - (0, 0, 0, 1)).max() <= _TOLERANCE
    return bool(straight and level and np.isfinite(pose).all())


def _rigid(rows: tuple[_Row, _Row, _Row, _Row]) -> tuple[_Row, _Row, _Row, _Row]:
    if not is_rigid(np.array(rows)):
        raise ValueError("expected four rows of a rigid pose, the last of them 0, 0, 0, 1")
    return rows


PoseRows = Annotated[tuple[_Row, _Row, _Row, _Row], AfterValidator(_rigid)]
"""A pose in a file: four rows of four numbers."""


def array_of(rows: PoseRows) -> Pose:
    """A pose from a file, with its rotation made exactly orthogonal, shape (4, 4)."""
    pose = np.array(rows)
    pose[:3, :3] = _nearest_rotation(pose[:3, :3])
    pose[3] = (0, 0, 0, 1)
    return pose


def rows_of(pose: Pose) -> PoseRows:
    """A pose as rows for a file, to a tenth of a micrometre."""
    a, b, c, d = (tuple(round(float(x), 7) for x in row) for row in pose)
    return (a, b, c, d)  # type: ignore[return-value]


def mean_pose(poses: Sequence[Pose]) -> Pose:
    """Mean of nearly equal poses: of their positions, and of their rotations by the chordal distance.

    Source: Hartley, Trumpf, Dai and Li, "Rotation Averaging", International Journal of Computer Vision 103 (2013).
    """
    found = np.mean(poses, axis=0)
    found[:3, :3] = _nearest_rotation(found[:3, :3])
    return np.asarray(found)


def angle_between(first: Pose, second: Pose) -> float:
    """Angle of the rotation from one pose to the other, degrees, 0 to 180."""
    apart = np.linalg.norm(first[:3, :3] - second[:3, :3]) / np.sqrt(8)
    return float(np.degrees(2 * np.arcsin(min(apart, 1.0))))


def _nearest_rotation(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    left, _, right = np.linalg.svd(matrix)
    left[:, -1] *= np.sign(np.linalg.det(left @ right))
    return np.asarray(left @ right)
