"""Hand-eye calibration: poses of the camera in the hand and of the board in the base, from views of a tagged board.

The camera is fixed to the hand and the board does not move. Hold-out errors come from four-fold cross-validation: the
error of a held-out view is the distance of its tags from their positions by the calibration of the other views.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe_robot.box_model.tag_layout import TagLayout
from lockprobe_robot.calibration.calibration_file import Calibration, CalibrationErrors
from lockprobe_robot.calibration.opencv import METHOD, board_pose, find_tags, hand_eye, read_grey
from lockprobe_robot.calibration.pose import Pose, angle_between, mean_pose, rows_of
from lockprobe_robot.calibration.views import CalibrationView, Intrinsics, Views, read_picture

FEWEST_TAGS = 3
"""The fewest tags of a view: with fewer, the board's pose error is far larger (robot/docs/robot.md)."""

FEWEST_VIEWS = 8
"""The fewest views of a calibration, of which a fourth is held out."""

LEAST_TURN = 10.0
"""Least rotation of the hand off its most frequent axis, degrees: with less, hand-eye is wrong without a sign of it."""

_FOLDS = 4


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BoardView:
    """A view in which the board was found.

    Attributes:
        picture: Name of the picture.
        hand: Pose of the hand in the robot's base, shape (4, 4).
        board: Pose of the board in the camera, shape (4, 4).
        tags: Number of tags seen.
        reprojection: Root mean square reprojection error of the corners, pixels.
    """

    picture: str
    hand: Pose
    board: Pose
    tags: int
    reprojection: float


def look_at_views(
    folder: Path, views: Views, tags: TagLayout, *, fewest_tags: int = FEWEST_TAGS
) -> tuple[list[BoardView], dict[str, str]]:
    """Find the board in the pictures of a folder.

    Args:
        folder: Where the pictures are.
        views: Its file of views.
        tags: The tags of the board.
        fewest_tags: Views with fewer tags are refused; at least 1.

    Returns:
        The views in which the board was found; the other pictures, each with the reason for its refusal.

    Raises:
        BadFile: If a picture cannot be read or has another size than the camera's.
        Missing: If OpenCV is not installed.
    """
    found: list[BoardView] = []
    refused: dict[str, str] = {}
    for view in views.views:
        seen = _look(folder, view, views.camera, tags, fewest_tags)
        if isinstance(seen, str):
            refused[view.picture] = seen
        else:
            found.append(seen)
    return found, refused


def _look(folder: Path, view: CalibrationView, camera: Intrinsics, tags: TagLayout, fewest: int) -> BoardView | str:
    """The view with the board's pose, or the reason for its refusal."""
    path = folder / view.picture
    grey = read_grey(read_picture(folder, view), path)
    height, width = grey.shape
    if (width, height) != (camera.width, camera.height):
        raise BadFile(path, f"{width} x {height} pixels; the camera has {camera.width} x {camera.height}")
    own = [(number, corners) for number, corners in find_tags(grey) if number < len(tags.middles)]
    numbers = sorted(number for number, _ in own)
    if len(set(numbers)) < len(numbers):
        return f"a tag is seen twice (seen: {_listed(numbers)})"
    if len(numbers) < fewest:
        return f"{len(numbers)} of {len(tags.middles)} tags seen ({_listed(numbers)}); {fewest} are needed"
    pose, reprojection = board_pose(tags.corners, dict(own), camera)
    return BoardView(picture=view.picture, hand=view.pose, board=pose, tags=len(own), reprojection=reprojection)


def _listed(numbers: Sequence[int]) -> str:
    return ", ".join(map(str, numbers)) or "none"


def calibrate(
    seen: Sequence[BoardView],
    refused: dict[str, str],
    *,
    camera: Intrinsics,
    tags: TagLayout,
    box: str,
    board: str,
    least_turn: float = LEAST_TURN,
) -> Calibration:
    """Calibrate camera and board.

    Args:
        seen: Views in which the board was found.
        refused: The other pictures, each with the reason; for the record.
        camera: The camera.
        tags: The tags of the board.
        box: Name of the box, for the record.
        board: Checksum of the board, for the record.
        least_turn: Least rotation of the hand off its dominant axis, degrees.

    Raises:
        BadValue: If there are too few views, the hand rotates too little, or no pose is found.
    """
    if len(seen) < FEWEST_VIEWS:
        raise BadValue("views with the board", len(seen), f"at least {FEWEST_VIEWS}; {len(refused)} were refused")
    turned = turned_degrees([view.hand for view in seen])
    if turned < least_turn:
        expected = f"at least {least_turn:g} degrees: turn the hand about two axes between views"
        raise BadValue("rotation of the hand off its most frequent axis", f"{turned:.1f} degrees", expected)
    eye, base = _solved(seen)
    millimetres, degrees = _held_out(seen, tags)
    return Calibration(
        date=datetime.now(UTC),
        box=box,
        board=board,
        tag_mm=1000 * tags.side,
        camera=camera,
        method=METHOD,
        camera_in_hand=rows_of(eye),
        board_in_base=rows_of(base),
        used=tuple(view.picture for view in seen),
        refused=refused,
        turned_degrees=round(turned, 2),
        errors=CalibrationErrors(
            held_out_mm=round(float(np.mean(millimetres)), 4),
            held_out_worst_mm=round(max(millimetres), 4),
            held_out_degrees=round(float(np.mean(degrees)), 4),
            held_out_worst_degrees=round(max(degrees), 4),
            reprojection_px=round(float(np.mean([view.reprojection for view in seen])), 4),
        ),
    )


def turned_degrees(hands: Sequence[Pose]) -> float:
    """Rotation of a hand between poses, off its dominant axis of rotation; degrees, root mean square.

    Hand-eye calibration knows the camera's position from this rotation alone. It is 0 if all rotations share one axis.
    """
    turns = np.array([hand[:3, :3] for hand in hands])
    moved = np.einsum("aji,bjk->abik", turns, turns) - np.eye(3)
    pairs = max(len(hands) * (len(hands) - 1), 1)
    least = np.linalg.eigvalsh(np.einsum("abji,abjk->ik", moved, moved) / pairs)[0]
    return float(np.degrees(2 * np.arcsin(min(np.sqrt(max(least, 0.0)) / 2, 1.0))))


def _solved(seen: Sequence[BoardView]) -> tuple[Pose, Pose]:
    """Pose of the camera in the hand, and of the board in the base."""
    eye = hand_eye([view.hand for view in seen], [view.board for view in seen])
    return eye, mean_pose([view.hand @ eye @ view.board for view in seen])


def _held_out(seen: Sequence[BoardView], tags: TagLayout) -> tuple[list[float], list[float]]:
    """Hold-out error of every view, in millimetres and degrees, by the calibration of the other folds."""
    middles = np.c_[tags.middles, np.zeros(len(tags.middles)), np.ones(len(tags.middles))].T
    millimetres, degrees = [], []
    for fold in range(_FOLDS):
        eye, base = _solved([view for i, view in enumerate(seen) if i % _FOLDS != fold])
        for view in seen[fold::_FOLDS]:
            here = view.hand @ eye @ view.board
            apart = np.linalg.norm(((here - base) @ middles)[:3], axis=0)
            millimetres.append(1000 * float(apart.mean()))
            degrees.append(angle_between(here, base))
    return millimetres, degrees
