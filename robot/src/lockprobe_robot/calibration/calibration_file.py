"""Calibration files (JSON): writing, reading, and the check before a study uses one."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Literal

from pydantic import AwareDatetime, BaseModel, ConfigDict, Field, FiniteFloat, ValidationError

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.inputs import parse_json, read_input
from lockprobe.foundation.storage.atomic_file import write_file
from lockprobe.foundation.terminal_text import printable
from lockprobe.foundation.validation import plain
from lockprobe_robot.calibration.pose import PoseRows
from lockprobe_robot.calibration.views import Intrinsics

TOLERATED_MM = 4.0
"""Largest error of a board's pose with which the guarded move is always right (robot/docs/twin.md), millimetres."""

_LARGEST = 1 << 20

_Positive = Annotated[FiniteFloat, Field(ge=0)]


class CalibrationErrors(BaseModel):
    """Hold-out and reprojection errors of a calibration.

    Attributes:
        held_out_mm: Hold-out error: mean distance of tags from their positions by the calibration of the other views,
            millimetres.
        held_out_worst_mm: The largest mean distance of a view, millimetres.
        held_out_degrees: Mean angle between a held-out view's board pose and the calibration's, degrees.
        held_out_worst_degrees: The largest such angle, degrees.
        reprojection_px: Reprojection error of corners, mean over views, pixels.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)
    held_out_mm: _Positive
    held_out_worst_mm: _Positive
    held_out_degrees: _Positive
    held_out_worst_degrees: _Positive
    reprojection_px: _Positive


class Calibration(BaseModel):
    """A calibration: poses of camera and board, with errors and provenance.

    Attributes:
        schema_version: Version of the file format.
        date: Time of computation.
        box: Name of the box.
        board: Checksum of the board's dimensions (:func:`lockprobe_robot.box_model.tag_layout.board_checksum`).
        tag_mm: Side of a tag's black square, millimetres.
        camera: The camera on the hand.
        method: Method of hand-eye calibration.
        camera_in_hand: Pose of the camera in the frame of the hand.
        board_in_base: Pose of the board in the frame of the robot's base.
        used: Names of the pictures used.
        refused: The other pictures, each with the reason.
        turned_degrees: Rotation of the hand between views off its dominant axis, degrees.
        errors: Errors.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)
    schema_version: Literal[1] = 1
    date: AwareDatetime
    box: str
    board: Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
    tag_mm: _Positive
    camera: Intrinsics
    method: str
    camera_in_hand: PoseRows
    board_in_base: PoseRows
    used: tuple[str, ...]
    refused: dict[str, str]
    turned_degrees: _Positive
    errors: CalibrationErrors


def write_calibration(found: Calibration, path: Path) -> None:
    """Write a calibration as a JSON file.

    Raises:
        BadFile: If it cannot be written.
    """
    write_file(path, found.model_dump_json(indent=2) + "\n")


def read_calibration(path: Path) -> Calibration:
    """Read the calibration in a file.

    Raises:
        BadFile: If the file is missing or not a calibration.
    """
    data = parse_json(read_input(path, _LARGEST), path)
    try:
        return Calibration.model_validate(data)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"])) or "calibration"
        raise BadFile(path, printable(f"{where}: {plain(first['msg'])}")) from None


def calibration_for(path: Path, *, board: str, board_file: Path | None = None) -> Calibration:
    """Read a calibration and check that a study may rely on it.

    Args:
        path: The calibration.
        board: Checksum of the board that the study uses.
        board_file: The file that describes the board, where there is one, such as the box's TOML file.

    Raises:
        BadFile: If it belongs to another board, is older than the board's file, or has a hold-out error above
            :data:`TOLERATED_MM`. The message says how to repair it.
    """
    found = read_calibration(path)
    again = "run lockprobe rig calibrate again"
    if found.board != board:
        raise BadFile(path, f"a calibration of another board (box {printable(found.box)}): {again}")
    if board_file is not None:
        try:
            changed = datetime.fromtimestamp(board_file.stat().st_mtime, UTC)
        except OSError as error:
            raise BadFile(board_file, f"cannot be read ({error.strerror})") from None
        if found.date < changed:
            dates = f"from {found.date:%Y-%m-%d %H:%M}, but {board_file} is from {changed:%Y-%m-%d %H:%M} (UTC)"
            raise BadFile(path, f"{dates}: {again}")
    if not found.errors.held_out_mm <= TOLERATED_MM:
        error_mm = f"hold-out error {found.errors.held_out_mm:.1f} mm, but the arm tolerates {TOLERATED_MM:g} mm"
        raise BadFile(path, f"{error_mm}: {again} with more views and more rotation")
    return found
