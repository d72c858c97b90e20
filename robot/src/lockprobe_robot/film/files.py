"""Writes films picture by picture, as GIF or MP4. What is interrupted plays up to there."""

from __future__ import annotations

import importlib.util
import struct
from itertools import islice, product
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray
from PIL import GifImagePlugin, Image

from lockprobe.foundation.errors import BadFile, BadValue, Missing
from lockprobe.foundation.storage.atomic_file import atomic_files, writable, write_file

RATES = {".gif": 12.5, ".mp4": 25.0}
"""Pictures per second by suffix."""

_STRONG = (*product((0, 255), repeat=3), (190, 30, 30))
"""Colours of every GIF in addition to those of its first picture."""

_GROWS = "-crf 20 -g 25 -movflags frag_keyframe+empty_moov -flush_packets 1"
"""Arguments of ffmpeg for a film that plays while it grows."""

_SAME = 255
"""Index of the transparent colour of a GIF: the pixel stays as it is."""


def open_film(path: Path) -> FilmFile:
    """Open a film for writing; the suffix decides its format.

    ``add`` adds a picture, shape (height, width, 3), the same for all, that lasts some seconds. The film is there from
    the first one on, in the place of an older one. ``close`` ends it, and may be called again; without a picture there
    is no film.

    Raises:
        BadValue: If the suffix is unknown.
        BadFile: If the film cannot be written there.
        Missing: If a package is missing.
    """
    kind = path.suffix.lower()
    if kind not in RATES:
        raise BadValue("out", str(path), "a name that ends in .gif or .mp4")
    if not path.parent.is_dir():
        raise BadFile(path, "its directory does not exist")
    return _Gif(path) if kind == ".gif" else _Mp4(path)


class _Gif:
    """Pictures with one palette. Of each only what changed is written, as one more block at the end of the file."""

    def __init__(self, path: Path) -> None:
        writable(path)
        self._path = path
        self._file: IO[bytes] | None = None
        self._palette = Image.new("P", (1, 1))
        self._last: NDArray[np.uint8] | None = None

    def add(self, picture: NDArray[np.uint8], seconds: float) -> None:
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
        if self._file is not None:
            self._file.write(b";")
            self._file.close()
            self._file = None


class _Mp4:
    """H.264 through the ffmpeg of the package imageio-ffmpeg."""

    def __init__(self, path: Path) -> None:
        if importlib.util.find_spec("imageio_ffmpeg") is None:
            raise Missing(
                "MP4 needs the package imageio-ffmpeg", "pip install 'lockprobe-robot[film]', or write a .gif"
            )
        writable(path)
        self._path = path
        self._pipe: Any = None  # the generator of imageio_ffmpeg
        self._owed = 0.0

    def add(self, picture: NDArray[np.uint8], seconds: float) -> None:
        if self._pipe is None:
            import imageio_ffmpeg

            write_file(self._path, b"")
            self._pipe = imageio_ffmpeg.write_frames(
                str(self._path),
                (picture.shape[1], picture.shape[0]),
                fps=RATES[".mp4"],
                codec="libx264",
                quality=None,
                macro_block_size=2,
                ffmpeg_log_level="error",
                output_params=_GROWS.split(),
            )
            self._pipe.send(None)
        self._owed += seconds * RATES[".mp4"]
        while self._owed > 0.5:
            self._pipe.send(np.ascontiguousarray(picture))
            self._owed -= 1

    def close(self) -> None:
        pipe, self._pipe = self._pipe, None
        if pipe is not None:
            pipe.close()


FilmFile = _Gif | _Mp4
