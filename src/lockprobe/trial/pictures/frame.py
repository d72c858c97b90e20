"""An RGB-D frame with its camera and the handles' positions; worse frames, images as PNG files, colours of depth."""

from __future__ import annotations

import io
import json
from dataclasses import dataclass, replace
from functools import cache
from importlib import resources
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue, needing

_PATCH: Final = 128
"""Grey level of the patch that hides a part of the panel."""

_MARGIN: Final = 0.5
"""Margin of the panel around the handles, as a share of a handle's travel."""

_COMPRESSION = {"compress_level": 1, "compress_type": 3}
"""Run-length matching only: twice as fast as the default, with files of the same size."""

_MOST_MILLIMETRES = 2**16 - 1

_MOST_PIXELS = 4096 * 4096
"""The largest picture of a plant. Files may come from elsewhere, so larger ones are refused."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Camera:
    """A pinhole camera that looks at a panel: its picture in pixels, its focal length in pixels, and its place.

    ``panel`` is the pose of the panel in the frame of the camera, shape (4, 4), metres. The frame of the panel: x to
    the right and y up as seen from the front, z out of the board; the origin is the middle of the board's front. The
    frame of the camera: x to the right, y down, z away from it.
    """

    width: int
    height: int
    focal: float
    panel: NDArray[np.float64]

    def project(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Where points of the panel's frame, shape (..., 3), metres, are in the image, of the same shape.

        Column and row are in pixels, from the middle of the top left pixel; the depth behind them is in metres.
        """
        seen = points @ self.panel[:3, :3].T + self.panel[:3, 3]
        middle = np.array([(self.width - 1) / 2, (self.height - 1) / 2])
        return np.concatenate([middle + self.focal * seen[..., :2] / seen[..., 2:], seen[..., 2:]], axis=-1)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Frame:
    """An aligned pair of a colour and a depth image.

    Attributes:
        rgb: Shape (height, width, 3), 0 to 255.
        depth: Shape (height, width), metres along the optical axis; 0 where there is no reading.
        handles: Top of each joint's handle at position 0 and at position 1, whatever the joint's position is now,
            shape (joints, 2, 3), metres in the frame of the panel.
        renderer: Name and version of the renderer.
        labelled: Whether the labels of the joints can be seen.
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    camera: Camera
    handles: NDArray[np.float64]
    renderer: str
    labelled: bool = True


def degraded(
    frame: Frame,
    luck: NDArray[np.float64],
    *,
    blur: float = 0.0,
    noise: float = 0.0,
    occlude: float = 0.0,
    exposure: float = 0.0,
) -> Frame:
    """A picture behind a patch, then blurred, exposed and with noise, by the options of a camera that describes them.

    A larger patch covers every smaller one, and more noise is the same noise scaled. ``luck`` holds three numbers,
    [0, 1): position of the patch across and down, and the seed of the noise.
    """
    if not (blur or noise or occlude or exposure):
        return frame
    rgb, depth = frame.rgb.astype(np.float64), frame.depth
    if occlude:
        places = frame.camera.project(frame.handles)[..., :2]
        apart = float(np.median(np.linalg.norm(places[:, 1] - places[:, 0], axis=-1)))
        low = places.min(axis=(0, 1)) - _MARGIN * apart
        size = places.max(axis=(0, 1)) + _MARGIN * apart - low
        first = low + luck[:2] * size * (1 - np.sqrt(occlude))
        ends = np.clip(np.rint([first, first + size * np.sqrt(occlude)]), 0, None).astype(int)
        patch, depth = tuple(slice(*ends[:, axis]) for axis in (1, 0)), depth.copy()
        rgb[patch], depth[patch] = _PATCH, 0
    if blur:
        from scipy.ndimage import gaussian_filter

        rgb = gaussian_filter(rgb, (blur, blur, 0), mode="nearest")
    if exposure:  # of light, which adds up before it is coded as sRGB
        coded = rgb / 255
        light = np.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4)
        light = np.clip(light * 2.0**exposure, 0, 1)
        rgb = 255 * np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    if noise:
        rng = np.random.Generator(np.random.PCG64(int(luck[2] * 2**53)))
        rgb = rgb + 255 * noise * rng.standard_normal(rgb.shape)
    return replace(frame, rgb=np.rint(np.clip(rgb, 0, 255)).astype(np.uint8), depth=depth)


def to_png(image: NDArray[np.uint8] | NDArray[np.uint16]) -> bytes:
    """Encode an image as a PNG file. Equal images give equal bytes.

    Its shape is (height, width) of uint8 or uint16, or (height, width, 3) of uint8.
    """
    with needing("pictures", "twin"):
        from PIL import Image
    file = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(image)).save(file, "PNG", **_COMPRESSION)
    return file.getvalue()


def from_png(png: bytes) -> NDArray[np.uint8] | NDArray[np.uint16]:
    """Decode a PNG file made by :func:`to_png`; ``BadValue`` if it is none."""
    with needing("pictures", "twin"):
        from PIL import Image
    try:
        with Image.open(io.BytesIO(png), formats=["PNG"]) as image:
            if image.width * image.height > _MOST_PIXELS:
                raise BadValue("picture", f"{image.width} x {image.height} pixels", f"at most {_MOST_PIXELS} in all")
            if image.mode not in ("L", "RGB", "I;16"):
                raise BadValue("picture", f"mode {image.mode}", "a PNG in grey of 8 or 16 bits, or in colour")
            if image.mode == "I;16":
                return np.asarray(image, dtype=np.uint16)
            return np.asarray(image, dtype=np.uint8)
    except (Image.DecompressionBombError, OSError, SyntaxError):  # no image at all is an OSError
        raise BadValue("picture", f"{len(png)} bytes", "a PNG file of a picture, not too large") from None


def to_millimetres(depth: NDArray[np.float32]) -> NDArray[np.uint16]:
    """Metres as whole millimetres; 0 (no reading) from 65.536 m on."""
    millimetres = np.rint(depth * np.float32(1000))
    return np.where(millimetres <= _MOST_MILLIMETRES, millimetres, 0).astype(np.uint16)


@cache
def turbo() -> NDArray[np.uint8]:
    """Google's turbo colour map from dark blue to dark red, shape (256, 3); no colour is black."""
    text = resources.files("lockprobe.trial.pictures").joinpath("turbo.json").read_text(encoding="utf-8")
    colours = np.array([list(bytes.fromhex(colour)) for colour in json.loads(text)["colours"]], np.uint8)
    colours.setflags(write=False)
    return colours
