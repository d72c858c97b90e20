"""Reads joint positions from pictures of a fixed camera, as the truth where nobody types it.

A file gives the place of each handle in the picture at position 0 and at position 1. The cues are those of the agent
``viewer`` (:mod:`lockprobe.trial.pictures.picture_reader`) at full acuity. A reading without clear evidence is no
reading.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.box import Configuration, Lockbox
from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.inputs import read_toml
from lockprobe.trial.pictures.frame import Camera, Frame
from lockprobe.trial.pictures.picture_reader import Handles, clear_positions
from lockprobe_robot.hardware.camera import Shot

HANDLES_FILE = "handles.toml"
"""The file with the places of handles, in the folder of the pictures."""

_NEAREST = 8.0
"""Pixels between the two places of a handle, at least."""


class Unclear(Exception):
    """Raised when a picture gives no clear position of a joint; the message names the joints."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ImageHandles:
    """The places of the handles in the pictures of a fixed camera.

    Attributes:
        size: Width and height of its pictures, pixels.
        places: For each joint in panel order (column, row) at position 0 and at position 1, pixels from the top left.
    """

    size: tuple[int, int]
    places: Handles

    def frame(self, shot: Shot) -> Frame:
        """The shot as a frame. The camera's pose is not known, so the panel is the plane of the picture."""
        width, height = self.size
        panel = np.eye(4)
        panel[2, 3] = 1.0
        middle = np.array([(width - 1) / 2, (height - 1) / 2])
        flat = np.array(self.places, dtype=float) - middle
        handles: NDArray[np.float64] = np.concatenate([flat, np.zeros((*flat.shape[:2], 1))], axis=-1)
        depth = shot.depth if shot.depth is not None else np.zeros((height, width), dtype=np.float32)
        camera = Camera(width=width, height=height, focal=1.0, panel=panel)
        return Frame(rgb=shot.rgb, depth=depth, camera=camera, handles=handles, renderer="camera")


def read_handles(path: Path, box: Lockbox) -> ImageHandles:
    """Read a TOML file of handles: ``width``, ``height``, and for each joint of the box ``at_0`` and ``at_1``.

    Raises:
        BadFile: If it cannot be read, a joint is missing, or a place lies outside the picture.
    """
    if not path.exists():
        raise BadFile(path, "no such file; it says where pictures show the handles (robot/docs/robot.md)")
    found = read_toml(path)
    size = tuple(found.get(name) for name in ("width", "height"))
    if not all(isinstance(side, int) and not isinstance(side, bool) and 64 <= side <= 4096 for side in size):
        raise BadFile(path, f"width and height are {size[0]} and {size[1]}, expected pixels from 64 to 4096")
    if unknown := sorted(set(found) - {"width", "height", *box.names}):
        raise BadFile(path, f"{box.name} has no joint {unknown[0]!r}; it has {', '.join(box.names)}")
    places = tuple(_places(path, name, found.get(name), size) for name in box.names)  # type: ignore[arg-type]
    return ImageHandles(size=size, places=places)  # type: ignore[arg-type] # checked above


def _places(
    path: Path, name: str, given: object, size: tuple[int, int]
) -> tuple[tuple[float, float], tuple[float, float]]:
    table = given if isinstance(given, Mapping) else {}
    places = []
    for end in ("at_0", "at_1"):
        place = table.get(end)
        numbers = place if isinstance(place, list) else []
        plain = [one for one in numbers if isinstance(one, int | float) and not isinstance(one, bool)]
        inside = len(plain) == len(numbers) == 2 and all(
            math.isfinite(one) and 0 <= one < side for one, side in zip(plain, size, strict=True)
        )
        if not inside:
            raise BadFile(path, f"{name}, {end}: got {place!r}, expected [column, row] inside {size[0]} x {size[1]}")
        places.append((float(plain[0]), float(plain[1])))
    if math.dist(*places) < _NEAREST:
        raise BadFile(path, f"{name}: at_0 and at_1 are nearer than {_NEAREST:g} pixels")
    return places[0], places[1]


def read_positions(shot: Shot, handles: Handles, names: tuple[str, ...]) -> Configuration:
    """Read the positions of all joints in a picture, in the order of ``handles``.

    Args:
        shot: The picture; its depth is not used.
        handles: The places of the handles at both positions.
        names: Names of the joints, for the message.

    Raises:
        Unclear: If a joint cannot be read.
    """
    found = clear_positions(shot.rgb, handles)
    if unclear := [name for name, one in zip(names, found, strict=True) if one is None]:
        raise Unclear(f"the picture does not show clearly where {', '.join(unclear)} stands")
    return tuple(map(bool, found))
