"""Conversion of arrays to PNG files and back."""

from __future__ import annotations

import io

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue, needing

_COMPRESSION = {"compress_level": 1, "compress_type": 3}
"""Run-length matching only: twice as fast as the default, with files of the same size."""

_MOST_PIXELS = 4096 * 4096
"""The largest picture of a plant. Files may come from elsewhere, so larger ones are refused."""


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
