"""The input of a calibration: a folder of pictures from a camera on a robot's hand, with the hand's poses.

The file ``views.json`` in the folder::

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

from pathlib import Path
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.inputs import parse_json, read_input
from lockprobe.foundation.terminal_text import printable
from lockprobe.foundation.validation import plain
from lockprobe_robot.calibration.pose import Pose, PoseRows, array_of

VIEWS_FILE = "views.json"

_LARGEST_FILE, _LARGEST_PICTURE = 1 << 20, 1 << 26
"""Bytes of the file of views and of a picture."""

_NAME = r"^[\w-][\w.-]{0,99}$"

_Side = Annotated[int, Field(ge=64, le=8192)]
_Focal = Annotated[FiniteFloat, Field(gt=0, le=1e5)]
_Distortion = Annotated[tuple[FiniteFloat, ...], Field(max_length=8)]


class Intrinsics(BaseModel):
    """Camera intrinsics: a pinhole camera with OpenCV's distortion model.

    Attributes:
        width: Pixels.
        height: Pixels.
        focal: Focal lengths along columns and rows, pixels.
        centre: Column and row of the optical axis, pixels from the middle of the top left pixel.
        distortion: OpenCV's k1, k2, p1, p2, k3, ...: none, 4, 5 or 8 numbers.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)
    width: _Side
    height: _Side
    focal: tuple[_Focal, _Focal]
    centre: tuple[FiniteFloat, FiniteFloat]
    distortion: _Distortion = ()

    @property
    def matrix(self) -> NDArray[np.float64]:
        """The camera matrix, shape (3, 3)."""
        return np.array([[self.focal[0], 0, self.centre[0]], [0, self.focal[1], self.centre[1]], [0, 0, 1]])


class CalibrationView(BaseModel):
    """One view: a picture and the hand's pose.

    Attributes:
        picture: File name of the picture in the folder.
        hand: Pose of the hand in the frame of the robot's base at that moment: four rows, metres.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)
    picture: Annotated[str, Field(pattern=_NAME)]
    hand: PoseRows

    @property
    def pose(self) -> Pose:
        """The hand's pose, shape (4, 4)."""
        return array_of(self.hand)


class Views(BaseModel):
    """The content of ``views.json``.

    Attributes:
        camera: The camera on the hand.
        views: At most 1000.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)
    camera: Intrinsics
    views: Annotated[tuple[CalibrationView, ...], Field(min_length=1, max_length=1000)]


def read_views(folder: Path) -> Views:
    """Read ``views.json`` in a folder.

    Raises:
        BadFile: If the file is missing, has another form, or names a picture twice.
    """
    path = folder / VIEWS_FILE
    data = parse_json(read_input(path, _LARGEST_FILE), path)
    try:
        found = Views.model_validate(data)
    except ValidationError as error:
        first = error.errors()[0]
        said = "expected the name of a file in the folder" if "pattern" in first.get("ctx", {}) else plain(first["msg"])
        raise BadFile(path, printable(f"{'.'.join(map(str, first['loc']))}: {said}")) from None
    if len(found.camera.distortion) not in (0, 4, 5, 8):
        raise BadFile(path, f"camera.distortion: {len(found.camera.distortion)} numbers; expected none, 4, 5 or 8")
    names = [view.picture for view in found.views]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise BadFile(path, f"names the picture {twice} twice")
    return found


def read_picture(folder: Path, view: CalibrationView) -> bytes:
    """The bytes of a view's picture file.

    Raises:
        BadFile: If it cannot be read or is too large.
    """
    return read_input(folder / view.picture, _LARGEST_PICTURE)
