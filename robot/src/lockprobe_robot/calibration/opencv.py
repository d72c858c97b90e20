"""Calibration with OpenCV: AprilTag detection, board pose (PnP), and hand-eye calibration.

No other module imports OpenCV. Version 5.0.0.93 has no ``calibrateHandEye`` in Python, so the extra pins 4.14.0.94.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadFile, BadValue, Missing, needing
from lockprobe.foundation.plugins import ROBOT
from lockprobe_robot.calibration.pose import Pose, is_rigid

if TYPE_CHECKING:
    from lockprobe_robot.calibration.views import Intrinsics

METHOD = "park"
"""The method of hand-eye calibration. On the twin Tsai's, Horaud's and Daniilidis' are as exact; in one of five runs
Andreff's was six times as wrong, and the hold-out error did not show it."""

_MOST_PIXELS = 8192 * 8192
_NO_FRAME = (0xC4, 0xC8, 0xCC)
"""Markers of JPEG among those of frames that hold tables instead of a size."""

_FROM_CORNER = 0.5
"""AprilTag's refinement counts from the corner of the top left pixel, and projections from its middle; pixels."""


@cache
def _opencv() -> Any:
    with needing("calibrations", "calibrate", ROBOT):
        import cv2
    if not hasattr(cv2, "calibrateHandEye"):
        what = f"calibrations need opencv 4.14; {cv2.__version__} has no hand-eye calibration in Python"
        raise Missing(what, "pip install 'lockprobe-robot[calibrate]'")
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)  # what fails here is said by an exception
    return cv2


def read_grey(content: bytes, path: Path) -> NDArray[np.uint8]:
    """Decode a PNG or JPEG file as a grey picture, shape (height, width).

    Raises:
        BadFile: If it is not a picture, or its header states too many pixels (checked before decoding).
        Missing: If OpenCV is not installed.
    """
    cv2 = _opencv()
    if not content.startswith((b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff")):
        raise BadFile(path, "not a PNG or JPEG picture")
    width, height = _stated_size(content)
    if width * height > _MOST_PIXELS:
        raise BadFile(path, f"{width} x {height} pixels; at most {_MOST_PIXELS} in all")
    how = cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION  # pixels as the lens put them
    try:
        picture = cv2.imdecode(np.frombuffer(content, np.uint8), how)
    except cv2.error:
        picture = None
    if picture is None:
        raise BadFile(path, "a picture that cannot be read")
    return np.asarray(picture, dtype=np.uint8)


def _stated_size(content: bytes) -> tuple[int, int]:
    """Width and height in the header of a PNG or JPEG file; 0, 0 where there are none."""
    if content.startswith(b"\x89PNG"):
        return int.from_bytes(content[16:20]), int.from_bytes(content[20:24])
    place = 2
    while place + 9 <= len(content) and content[place] == 0xFF:
        marker = content[place + 1]
        if 0xC0 <= marker <= 0xCF and marker not in _NO_FRAME:
            return int.from_bytes(content[place + 7 : place + 9]), int.from_bytes(content[place + 5 : place + 7])
        place += 2 + int.from_bytes(content[place + 2 : place + 4])
    return 0, 0


def find_tags(grey: NDArray[np.uint8]) -> list[tuple[int, NDArray[np.float64]]]:
    """Detect the AprilTags of the family 36h11 in a picture.

    Args:
        grey: Shape (height, width).

    Returns:
        For each its number and its corners, shape (4, 2): column and row in pixels from the middle of the top left
        pixel, in the order upper left, upper right, lower right, lower left of the tag.

    Raises:
        Missing: If OpenCV is not installed.
    """
    corners, numbers, _ = _detector().detectMarkers(grey)
    if numbers is None:
        return []
    pairs = zip(numbers.ravel(), corners, strict=True)
    return [(int(number), np.asarray(four, dtype=np.float64).reshape(4, 2) - _FROM_CORNER) for number, four in pairs]


@cache
def _detector() -> Any:
    cv2 = _opencv()
    settings = cv2.aruco.DetectorParameters()
    settings.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_APRILTAG
    return cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11), settings)


def board_pose(
    corners: NDArray[np.float64], found: Mapping[int, NDArray[np.float64]], camera: Intrinsics
) -> tuple[Pose, float]:
    """Pose of a board in the frame of the camera, from all its tags in a picture (perspective-n-point).

    The start is the better of the two poses of a plane (Collins and Bartoli, "Infinitesimal Plane-Based Pose
    Estimation", 2014); Levenberg-Marquardt refines it.

    Args:
        corners: Corners of the board's tags by number, shape (tags, 4, 3), metres in the frame of the board.
        found: Tags in the picture as :func:`find_tags` has them; their numbers are those of ``corners``.
        camera: The camera.

    Returns:
        The pose, shape (4, 4); root mean square reprojection error, pixels.
    """
    cv2 = _opencv()
    numbers = sorted(found)
    points = np.ascontiguousarray(corners[numbers].reshape(-1, 3))
    pixels = np.concatenate([found[number] for number in numbers])
    lens = (camera.matrix, np.array(camera.distortion, dtype=np.float64))
    _, turns, shifts, _ = cv2.solvePnPGeneric(points, pixels, *lens, flags=cv2.SOLVEPNP_IPPE)
    turn, shift = cv2.solvePnPRefineLM(points, pixels, *lens, turns[0], shifts[0])
    seen, _ = cv2.projectPoints(points, turn, shift, *lens)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = cv2.Rodrigues(turn)[0], shift.ravel()
    return pose, float(np.sqrt(((seen.reshape(-1, 2) - pixels) ** 2).sum(1).mean()))


def hand_eye(hands: Sequence[Pose], boards: Sequence[Pose]) -> Pose:
    """Hand-eye calibration: the pose of a camera in the frame of the hand that carries it.

    Args:
        hands: Poses of the hand in the frame of the robot's base, shape (4, 4) each.
        boards: Poses of a board that does not move, in the frame of the camera.

    Returns:
        Shape (4, 4).

    Raises:
        BadValue: If no pose is found: OpenCV then returns the identity, non-finite numbers or a reflection.
    """
    cv2 = _opencv()
    turn, shift = cv2.calibrateHandEye(
        [hand[:3, :3] for hand in hands],
        [hand[:3, 3] for hand in hands],
        [board[:3, :3] for board in boards],
        [board[:3, 3] for board in boards],
        method=cv2.CALIB_HAND_EYE_PARK,  # by its name: OpenCV ignores it in its place
    )
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn, shift.ravel()
    if not is_rigid(pose) or np.array_equal(pose, np.eye(4)):
        expected = "views with more rotation, and tags in their places: no pose of the camera is found"
        raise BadValue("views", len(hands), expected)
    return pose
