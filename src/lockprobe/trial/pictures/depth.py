"""Depth maps as pictures, over a fixed window, so that a colour means the same distance in every picture."""

from __future__ import annotations

import functools
import json
from importlib import resources
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lockprobe.trial.pictures.frame import Camera

DepthKind = Literal["turbo", "height"]
"""Colours from near to far, or by height above the board."""


HEIGHTS = (-0.02, 0.06)
"""The window of pictures by height, metres above the board: handles end at 0.05, and the ground is below the board."""

_MOST_MILLIMETRES = 2**16 - 1


def encode(
    depth: NDArray[np.float32], kind: DepthKind, window: tuple[float, float], camera: Camera
) -> NDArray[np.uint8]:
    """Encode depth as a picture, shape (height, width, 3). A value outside the window has the colour of its nearer end.

    ``depth`` has the shape (height, width), metres; 0 where there is no reading, which is black. ``window`` holds
    the depths of the first and the last colour of ``turbo``, metres; ``height`` has :data:`HEIGHTS`, and needs the pose
    of the camera.
    """
    values, first, last = (camera.heights(depth), *HEIGHTS) if kind == "height" else (depth, *window[::-1])
    level: NDArray[np.uint8] = np.rint(np.clip((values - first) / (last - first), 0, 1) * 255).astype(np.uint8)
    colours = np.take(turbo(), level, axis=0)
    colours[depth <= 0] = 0
    return colours


def legend(kind: DepthKind, window: tuple[float, float]) -> str:
    """The meaning of the colours in one sentence."""
    if kind == "height":
        return (
            f"Colour is height: dark violet {-100 * HEIGHTS[0]:g} cm or more below the board, blue the board, "
            f"through green and yellow to red {100 * HEIGHTS[1]:g} cm or more above it, black no reading."
        )
    return (
        f"Colour is distance from the camera: red {window[0]:g} m or nearer, through yellow, green and blue to dark "
        f"violet {window[1]:g} m or farther, black no reading."
    )


def to_millimetres(depth: NDArray[np.float32]) -> NDArray[np.uint16]:
    """Metres as whole millimetres; 0 (no reading) from 65.536 m on."""
    millimetres = np.rint(depth * np.float32(1000))
    return np.where(millimetres <= _MOST_MILLIMETRES, millimetres, 0).astype(np.uint16)


@functools.cache
def turbo() -> NDArray[np.uint8]:
    """Google's turbo colour map from dark blue to dark red, shape (256, 3); no colour is black."""
    text = resources.files("lockprobe.trial.pictures").joinpath("turbo.json").read_text(encoding="utf-8")
    colours = np.array([list(bytes.fromhex(colour)) for colour in json.loads(text)["colours"]], np.uint8)
    colours.setflags(write=False)
    return colours
