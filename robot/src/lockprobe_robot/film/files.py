"""Writes a film picture by picture, as a GIF. What is interrupted plays up to there."""

from __future__ import annotations

import struct
from itertools import islice, product
from pathlib import Path
from typing import IO

import numpy as np
from numpy.typing import NDArray
from PIL import GifImagePlugin, Image

from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.foundation.storage.atomic_file import atomic_files, writable

_STRONG = (*product((0, 255), repeat=3), (190, 30, 30))
"""Colours of every film in addition to those of its first picture."""

_SAME = 255
"""Index of the transparent colour: the pixel stays as it is."""


class FilmFile:
    """A GIF with one palette. Of each picture only what changed is written, as one more block at the end of the file.

    The film is there from the first picture on, in the place of an older one; without a picture there is no film.

    Args:
        path: A name that ends in ``.gif``.

    Raises:
        BadValue: If it does not.
        BadFile: If the film cannot be written there.
    """

    def __init__(self, path: Path) -> None:
        if path.suffix.lower() != ".gif":
            raise BadValue("out", str(path), "a name that ends in .gif")
        if not path.parent.is_dir():
            raise BadFile(path, "its directory does not exist")
        writable(path)
        self._path = path
        self._file: IO[bytes] | None = None
        self._palette = Image.new("P", (1, 1))
        self._last: NDArray[np.uint8] | None = None

    def add(self, picture: NDArray[np.uint8], seconds: float) -> None:
        """Add a picture that lasts some seconds, shape (height, width, 3), the same for all."""
        image = Image.fromarray(picture)
        if self._file is None:
            found = iter(image.quantize(_SAME - len(_STRONG)).getpalette() or [])
            chosen = list(dict.fromkeys([*_STRONG, *zip(found, found, found, strict=True)]))
            spare = (colour for colour in product((255, 0), (1, 254), range(256)) if colour not in chosen)
            chosen += islice(spare, _SAME + 1 - len(chosen))  # all different
            colours = [part for colour in chosen for part in colour]
            self._palette.putpalette(colours)
            with atomic_files(self._path) as (draft,):
                self._file = draft.open("r+b")
                self._file.write(struct.pack("<6s2H3B", b"GIF89a", *image.size, 0xF7, 0, 0) + bytes(colours))
                self._file.write(b"\x21\xff\x0bNETSCAPE2.0\x03\x01\x00\x00\x00")  # again and again
                self._file.flush()
        few = np.asarray(image.quantize(palette=self._palette, dither=Image.Dither.NONE))
        few = np.where(few == _SAME, 0, few).astype(np.uint8)
        top, left, shown = 0, 0, few
        if self._last is not None:
            changed = few != self._last
            rows, columns = np.flatnonzero(changed.any(axis=1)), np.flatnonzero(changed.any(axis=0))
            if rows.size == 0:
                rows = columns = np.array([0])
            top, left = int(rows[0]), int(columns[0])
            part = np.s_[top : rows[-1] + 1, left : columns[-1] + 1]
            shown = np.where(changed[part], few[part], _SAME).astype(np.uint8)
        self._last = few
        block = Image.fromarray(shown, "P")
        how = {"duration": round(1000 * seconds), "transparency": _SAME, "disposal": 1}
        self._file.write(b"".join(GifImagePlugin.getdata(block, (left, top), **how)))
        self._file.flush()

    def close(self) -> None:
        """End the film; it may be called again."""
        if self._file is not None:
            self._file.write(b";")
            self._file.close()
            self._file = None
