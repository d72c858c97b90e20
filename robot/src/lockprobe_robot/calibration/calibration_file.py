"""The files of a calibration: ``views.json`` beside the pictures, and the calibration that is made of them.

``views.json`` says which camera took the pictures, and where the hand was at each::

    {
      "camera": {"width": 640, "height": 480, "focal": [433.0, 433.0], "centre": [319.5, 239.5],
                 "distortion": [0, 0, 0, 0, 0]},
      "views": [
        {"picture": "00.png", "hand": [[1, 0, 0, 0.4], [0, -1, 0, 0.0], [0, 0, -1, 0.6], [0, 0, 0, 1]]}
      ]
    }

robot/docs/robot.md describes every key.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, AwareDatetime, Field, FiniteFloat
from scipy.spatial.transform import Rotation

from lockprobe.boxes.box import Lockbox
from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.inputs import parse_json, read_input
from lockprobe.foundation.terminal_text import printable
from lockprobe.foundation.validation import Written, validated
from lockprobe.trial.record import Fact
from lockprobe_robot.box_model.panel import PanelLayout, lay_out_panel
from lockprobe_robot.box_model.tag_layout import board_checksum

VIEWS_FILE = "views.json"

TOLERATED_MM = 4.0
"""Largest error of a board's pose with which the guarded move is always right (robot/docs/twin.md), millimetres."""

_LARGEST = 1 << 20
"""Bytes of a file."""

_TOLERANCE = 1e-3
"""Largest deviation from a rotation: poses are typed and printed with a few digits."""

Pose = NDArray[np.float64]
"""Shape (4, 4): rotation and position in metres of one frame in another."""

_Row = tuple[FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat]
_Positive = Annotated[FiniteFloat, Field(ge=0)]
_Above = Annotated[FiniteFloat, Field(gt=0)]


def is_rigid(pose: Pose) -> bool:
    """Whether a matrix of shape (4, 4) is a rigid pose, within the precision of typed numbers."""
    turn, last = pose[:3, :3], pose[3] - (0, 0, 0, 1)
    straight = np.abs(turn @ turn.T - np.eye(3)).max() < _TOLERANCE and np.linalg.det(turn) > 0
    return bool(straight and np.abs(last).max() <= _TOLERANCE and np.isfinite(pose).all())


def _rigid(rows: tuple[_Row, _Row, _Row, _Row]) -> tuple[_Row, _Row, _Row, _Row]:
    if not is_rigid(np.array(rows)):
        raise ValueError("expected four rows of a rigid pose, the last of them 0, 0, 0, 1")
    return rows


PoseRows = Annotated[tuple[_Row, _Row, _Row, _Row], AfterValidator(_rigid)]
"""A pose in a file: four rows of four numbers."""


def array_of(rows: PoseRows) -> Pose:
    """A pose from a file, with its rotation made exactly orthogonal, shape (4, 4)."""
    given = np.array(rows)
    return pose_of(Rotation.from_matrix(given[:3, :3]).as_matrix(), given[:3, 3])


def pose_of(turn: NDArray[np.float64], shift: NDArray[np.float64]) -> Pose:
    """The pose of a rotation, shape (3, 3), and a position."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn, shift.ravel()
    return pose


class Intrinsics(Written):
    """A pinhole camera in pixels from the middle of the top left one, with OpenCV's distortion (k1, k2, p1, p2, k3)."""

    width: int
    height: int
    focal: tuple[_Above, _Above]
    centre: tuple[FiniteFloat, FiniteFloat]
    distortion: Annotated[tuple[FiniteFloat, ...], Field(max_length=8)] = ()

    @property
    def matrix(self) -> NDArray[np.float64]:
        """The camera matrix, shape (3, 3)."""
        return np.array([[self.focal[0], 0, self.centre[0]], [0, self.focal[1], self.centre[1]], [0, 0, 1]])


class CalibrationView(Written):
    """One view: the file name of a picture in the folder, and the pose of the hand in the robot's base, metres."""

    picture: Annotated[str, Field(pattern=r"^[\w-][\w.-]{0,99}$")]
    hand: PoseRows


class Views(Written):
    """The content of ``views.json``."""

    camera: Intrinsics
    views: Annotated[tuple[CalibrationView, ...], Field(min_length=1, max_length=1000)]


class Calibration(Written):
    """A calibration: poses of camera and board, with errors and provenance.

    Attributes:
        date: Time of computation.
        box: Name of the box.
        board: Checksum of the board's dimensions (:func:`lockprobe_robot.box_model.tag_layout.board_checksum`).
        camera_in_hand: Pose of the camera in the frame of the hand.
        board_in_base: Pose of the board in the frame of the robot's base.
        used: Names of the pictures used.
        refused: The other pictures, each with the reason.
        turned_degrees: Rotation of the hand between views off its dominant axis, degrees.
        held_out_mm: Hold-out error: mean distance of tags from their positions by the calibration of the other views,
            millimetres.
        held_out_worst_mm: The largest mean distance of a view, millimetres.
        reprojection_px: Reprojection error of corners, mean over views, pixels.
    """

    date: AwareDatetime
    box: str
    board: str
    camera_in_hand: PoseRows
    board_in_base: PoseRows
    used: tuple[str, ...]
    refused: dict[str, str]
    turned_degrees: _Positive
    held_out_mm: _Positive
    held_out_worst_mm: _Positive
    reprojection_px: _Positive


def read_views(folder: Path) -> Views:
    """Read ``views.json`` in a folder.

    Raises:
        BadFile: If the file is missing, has another form, or names a picture twice.
    """
    path = folder / VIEWS_FILE
    found = validated(Views, parse_json(read_input(path, _LARGEST), path), path)
    if len(found.camera.distortion) not in (0, 4, 5, 8):
        raise BadFile(path, f"camera.distortion: {len(found.camera.distortion)} numbers; expected none, 4, 5 or 8")
    names = [view.picture for view in found.views]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise BadFile(path, f"names the picture {twice} twice")
    return found


def calibrated_board(box: Lockbox, path: Path | str) -> tuple[PanelLayout, Mapping[str, Fact]]:
    """A board at the pose that ``lockprobe rig calibrate`` found, and how it was found, for the record.

    Call it before the robot is connected, so that an unreliable calibration refuses the study before the first motion.

    Raises:
        BadFile: If the calibration cannot be read, belongs to another board, or has a hold-out error above
            :data:`TOLERATED_MM`.
    """
    path, panel = Path(path), lay_out_panel(box)
    content, again = read_input(path, _LARGEST), "run lockprobe rig calibrate again"
    found = validated(Calibration, parse_json(content, path), path)
    if found.board != board_checksum(panel):
        raise BadFile(path, f"a calibration of another board (box {printable(found.box)}): {again}")
    if not found.held_out_mm <= TOLERATED_MM:
        error_mm = f"hold-out error {found.held_out_mm:.1f} mm, but the arm tolerates {TOLERATED_MM:g} mm"
        raise BadFile(path, f"{error_mm}: {again} with more views and more rotation")
    facts: dict[str, Fact] = {
        "calibration_sha256": hashlib.sha256(content).hexdigest(),
        "calibration_held_out_mm": round(found.held_out_mm, 3),
    }
    return replace(panel, pose=array_of(found.board_in_base)), facts
