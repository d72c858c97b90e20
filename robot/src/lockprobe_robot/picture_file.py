"""Picture files of others (PNG, JPEG), read as untrusted data with limits."""

from __future__ import annotations

import warnings
from io import BytesIO
from pathlib import Path

from PIL import Image

from lockprobe.foundation.errors import BadFile

LONGEST_SIDE = 8192
"""Pixels along each side of a picture."""


def open_picture(content: bytes, path: Path, *, longest: int = LONGEST_SIDE) -> Image.Image:
    """The decoded picture in the content of a file, with its pixels in the order in which they are stored.

    Raises:
        BadFile: If it is no whole PNG or JPEG picture, or has a side of more than ``longest`` pixels, which its header
            says before anything is decoded.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            picture = Image.open(BytesIO(content), formats=["PNG", "JPEG"])
        if max(picture.size) > longest:
            raise BadFile(path, f"a picture of {picture.width} x {picture.height} pixels; at most {longest} are read")
        picture.load()
    except (Image.DecompressionBombError, Image.DecompressionBombWarning, OSError, SyntaxError, ValueError):
        raise BadFile(path, "no whole PNG or JPEG picture") from None
    return picture
