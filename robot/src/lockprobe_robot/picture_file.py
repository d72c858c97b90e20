"""Picture files of others (PNG, JPEG), read as untrusted data with limits."""

from __future__ import annotations

import warnings
from io import BytesIO
from pathlib import Path

from PIL import Image

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.inputs import read_input

_LARGEST = 1 << 26
"""Bytes of a file."""


def open_picture(path: Path, content: bytes | None = None, *, longest: int = 8192) -> Image.Image:
    """The decoded picture in a file, with its pixels in the order in which they are stored.

    ``content`` is that of the file, where it was read before; ``longest`` are the most pixels along each side.

    Raises:
        BadFile: If it cannot be read, is no whole PNG or JPEG picture, or has a longer side, as its header says before
            anything is decoded.
    """
    content = read_input(path, _LARGEST) if content is None else content
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
