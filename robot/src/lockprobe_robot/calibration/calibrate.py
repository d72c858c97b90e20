"""Hand-eye calibration with OpenCV: where camera and board are, from views of a board with AprilTags.

The camera is fixed to the hand and the board does not move. Hold-out errors come from four-fold cross-validation: the
error of a held-out view is the distance of its tags from their positions by the calibration of the other views. No
other module imports OpenCV. Version 5.0.0.93 has no ``calibrateHandEye`` in Python, so the extra pins 4.14.0.94.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from lockprobe.foundation.errors import BadFile, BadValue, Missing, needing
from lockprobe.foundation.plugins import ROBOT
from lockprobe_robot.box_model.panel import PanelLayout
from lockprobe_robot.box_model.tag_layout import TAG_SIDE, board_checksum, place_tags, tag_corners
from lockprobe_robot.calibration.calibration_file import (
    Calibration,
    Intrinsics,
    Pose,
    array_of,
    is_rigid,
    pose_of,
    read_views,
)
from lockprobe_robot.picture_file import open_picture

FEWEST_TAGS = 3
"""The fewest tags of a view: with fewer, the board's pose error is far larger (robot/docs/robot.md)."""

FEWEST_VIEWS = 8
"""The fewest views of a calibration, of which a fourth is held out."""

LEAST_TURN = 10.0
"""Least rotation of the hand off its most frequent axis, degrees: with less, hand-eye is wrong without a sign of it."""

_FOLDS = 4

_FROM_CORNER = 0.5
"""AprilTag's refinement counts from the corner of the top left pixel, and projections from its middle; pixels."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BoardView:
    """A view in which the board was found.

    Attributes:
        picture: Name of the picture.
        hand: Pose of the hand in the robot's base, shape (4, 4).
        board: Pose of the board in the camera, shape (4, 4).
        reprojection: Root mean square reprojection error of the corners, pixels.
    """

    picture: str
    hand: Pose
    board: Pose
    reprojection: float


def calibrate(folder: Path, panel: PanelLayout, box: str, *, side: float = TAG_SIDE) -> Calibration:
    """Calibrate camera and board from the pictures of a folder and their ``views.json``.

    Args:
        folder: The folder.
        panel: The board that the pictures show; its tags lie where ``place_tags`` says.
        box: Name of its box, for the record.
        side: Side of a printed tag's black square, metres.

    Raises:
        BadFile: If the file of views or a picture cannot be read, or a picture has another size than the camera's.
        BadValue: If there are too few views, the hand rotates too little, or no pose is found.
        Missing: If OpenCV is not installed.
    """
    _opencv()  # a missing package is said before anything is read
    views, middles = read_views(folder), place_tags(panel)
    seen: list[BoardView] = []
    refused: dict[str, str] = {}
    for view in views.views:
        path = folder / view.picture
        grey = np.asarray(open_picture(path).convert("L"))
        if grey.shape != (views.camera.height, views.camera.width):
            size, wanted = grey.shape[::-1], (views.camera.width, views.camera.height)
            raise BadFile(path, f"{size[0]} x {size[1]} pixels; the camera has {wanted[0]} x {wanted[1]}")
        tags = {number: corners for number, corners in find_tags(grey).items() if number < len(middles)}
        if len(tags) < FEWEST_TAGS:
            numbers = ", ".join(map(str, sorted(tags))) or "none"
            refused[view.picture] = f"{len(tags)} of {len(middles)} tags seen ({numbers}); {FEWEST_TAGS} are needed"
        else:
            pose, missed = board_pose(tag_corners(middles, side), tags, views.camera)
            seen.append(BoardView(picture=view.picture, hand=array_of(view.hand), board=pose, reprojection=missed))
    if len(seen) < FEWEST_VIEWS:
        reasons = "; ".join(f"{picture}: {why}" for picture, why in refused.items())
        raise BadValue("views with the board", len(seen), f"at least {FEWEST_VIEWS} ({reasons or 'none was refused'})")
    turned = turned_degrees([view.hand for view in seen])
    if turned < LEAST_TURN:
        expected = f"at least {LEAST_TURN:g} degrees: turn the hand about two axes between views"
        raise BadValue("rotation of the hand off its most frequent axis", f"{turned:.1f} degrees", expected)
    eye, base = solved(seen)
    missed_mm = _held_out(seen, middles)
    return Calibration(
        date=datetime.now(UTC),
        box=box,
        board=board_checksum(panel),
        camera_in_hand=np.round(eye, 7).tolist(),
        board_in_base=np.round(base, 7).tolist(),
        used=tuple(view.picture for view in seen),
        refused=refused,
        turned_degrees=round(turned, 2),
        held_out_mm=round(float(np.mean(missed_mm)), 4),
        held_out_worst_mm=round(max(missed_mm), 4),
        reprojection_px=round(float(np.mean([view.reprojection for view in seen])), 4),
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


def solved(seen: Sequence[BoardView]) -> tuple[Pose, Pose]:
    """Pose of the camera in the hand, and of the board in the base: the mean of where the views see it.

    The method is Park's. On the twin Tsai's, Horaud's and Daniilidis' are as exact; in one of five runs Andreff's was
    six times as wrong, and the hold-out error did not show it.

    Raises:
        BadValue: If no pose is found: OpenCV then returns the identity, non-finite numbers or a reflection.
    """
    cv2 = _opencv()
    turn, shift = cv2.calibrateHandEye(
        [view.hand[:3, :3] for view in seen],
        [view.hand[:3, 3] for view in seen],
        [view.board[:3, :3] for view in seen],
        [view.board[:3, 3] for view in seen],
        method=cv2.CALIB_HAND_EYE_PARK,  # by its name: OpenCV ignores it in its place
    )
    eye = pose_of(turn, shift)
    if not is_rigid(eye) or np.array_equal(eye, np.eye(4)):
        expected = "views with more rotation, and tags in their places: no pose of the camera is found"
        raise BadValue("views", len(seen), expected)
    boards = np.array([view.hand @ eye @ view.board for view in seen])
    return eye, pose_of(Rotation.from_matrix(boards[:, :3, :3]).mean().as_matrix(), boards[:, :3, 3].mean(axis=0))


def _held_out(seen: Sequence[BoardView], tags: NDArray[np.float64]) -> list[float]:
    """Hold-out error of every view, millimetres, by the calibration of the other folds."""
    middles = np.c_[tags, np.zeros(len(tags)), np.ones(len(tags))].T
    missed = []
    for fold in range(_FOLDS):
        eye, base = solved([view for i, view in enumerate(seen) if i % _FOLDS != fold])
        apart = [(view.hand @ eye @ view.board - base) @ middles for view in seen[fold::_FOLDS]]
        missed += [1000 * float(np.linalg.norm(one[:3], axis=0).mean()) for one in apart]
    return missed


def find_tags(grey: NDArray[np.uint8]) -> dict[int, NDArray[np.float64]]:
    """Detect the AprilTags of the family 36h11 in a picture of shape (height, width).

    Returns:
        Number -> corners, shape (4, 2): column and row in pixels from the middle of the top left pixel, in the order
        upper left, upper right, lower right, lower left of the tag.
    """
    aruco = _opencv().aruco
    settings = aruco.DetectorParameters()
    settings.cornerRefinementMethod = aruco.CORNER_REFINE_APRILTAG
    detector = aruco.ArucoDetector(aruco.getPredefinedDictionary(aruco.DICT_APRILTAG_36h11), settings)
    corners, numbers, _ = detector.detectMarkers(grey)
    pairs = zip(numbers.ravel(), corners, strict=True) if numbers is not None else ()
    return {int(number): np.asarray(four, dtype=np.float64).reshape(4, 2) - _FROM_CORNER for number, four in pairs}


def board_pose(
    corners: NDArray[np.float64], found: Mapping[int, NDArray[np.float64]], camera: Intrinsics
) -> tuple[Pose, float]:
    """Pose of a board in the frame of the camera, from all its tags in a picture (perspective-n-point).

    The start is the better of the two poses of a plane (Collins and Bartoli, "Infinitesimal Plane-Based Pose
    Estimation", 2014); Levenberg-Marquardt refines it.

    Args:
        corners: Corners of the board's tags by number, shape (tags, 4, 3), metres in the frame of the board.
        found: Number -> corners of the tags in the picture, as :func:`find_tags` has them.
        camera: The camera.

    Returns:
        The pose, shape (4, 4); root mean square reprojection error, pixels.
    """
    cv2, numbers = _opencv(), sorted(found)
    points = np.ascontiguousarray(corners[numbers].reshape(-1, 3))
    pixels = np.concatenate([found[number] for number in numbers])
    lens = (camera.matrix, np.array(camera.distortion, dtype=np.float64))
    _, turns, shifts, _ = cv2.solvePnPGeneric(points, pixels, *lens, flags=cv2.SOLVEPNP_IPPE)
    turn, shift = cv2.solvePnPRefineLM(points, pixels, *lens, turns[0], shifts[0])
    seen, _ = cv2.projectPoints(points, turn, shift, *lens)
    missed = float(np.sqrt(((seen.reshape(-1, 2) - pixels) ** 2).sum(1).mean()))
    return pose_of(cv2.Rodrigues(turn)[0], shift), missed


@cache
def _opencv() -> Any:
    with needing("calibrations", "calibrate", ROBOT):
        import cv2
    if not hasattr(cv2, "calibrateHandEye"):
        what = f"calibrations need opencv 4.14; {cv2.__version__} has no hand-eye calibration in Python"
        raise Missing(what, "pip install 'lockprobe-robot[calibrate]'")
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)  # what fails here is said by an exception
    return cv2
