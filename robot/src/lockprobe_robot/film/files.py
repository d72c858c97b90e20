"""Writes films picture by picture: GIF, MP4 or a directory of pictures."""

from __future__ import annotations

import importlib.util
import zlib
from collections.abc import Generator, Iterator
from itertools import islice, product
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadFile, BadValue, Missing
from lockprobe.foundation.storage.atomic_file import NewDirectory, Replacement
from lockprobe.trial.pictures.png import to_png

if TYPE_CHECKING:
    from PIL.Image import Image

RATES = {".gif": 12.5, ".mp4": 25.0, "": 12.5}
"""Pictures per second by suffix; a path without suffix is a directory of pictures."""

_STRONG = (*product((0, 255), repeat=3), (190, 30, 30))
"""Colours of every GIF in addition to those of its first picture."""

_SAME = 255
"""Index of the transparent colour of a GIF: the pixel stays as it is."""


class FilmFile(Protocol):
    """A film file that is being written."""

    def add(self, picture: NDArray[np.uint8], seconds: float) -> None:
        """Add a picture.

        Args:
            picture: Shape (height, width, 3), the same for all.
            seconds: Its duration.
        """
        ...

    def close(self) -> None:
        """Finish the file. The file appears only with this call."""
        ...

    def drop(self) -> None:
        """Release everything and discard an unfinished file. Idempotent."""
        ...


def open_film(path: Path) -> FilmFile:
    """Open a film for writing; the suffix decides its format.

    Raises:
        BadValue: If the suffix is unknown.
        BadFile: If the film cannot be written there.
        Missing: If a package is missing.
    """
    kind = path.suffix.lower()
    if kind not in RATES:
        raise BadValue("out", str(path), "a name that ends in .gif or .mp4, or a directory's")
    if not path.parent.is_dir():
        raise BadFile(path, "its directory does not exist")
    if importlib.util.find_spec("PIL") is None:
        raise Missing("films need the package pillow", "pip install 'lockprobe[twin]'")
    if kind == ".gif":
        return _Gif(path)
    if kind == ".mp4":
        return _Mp4(path)
    return _Directory(path)


class _Gif:
    """Pictures with one palette, so that unchanged pixels cost nothing."""

    def __init__(self, path: Path) -> None:
        self._file = Replacement(path)
        self._colours: list[int] = []
        self._palette: Image | None = None
        self._size = (0, 0)
        self._frames: list[tuple[bytes, int]] = []

    def add(self, picture: NDArray[np.uint8], seconds: float) -> None:
        from PIL import Image

        image = Image.fromarray(picture)
        if self._palette is None:
            self._colours, self._size = _colours(image), image.size
            self._palette = Image.new("P", (1, 1))
            self._palette.putpalette(self._colours)
        few = np.asarray(image.quantize(palette=self._palette, dither=Image.Dither.NONE))
        few = np.where(few == _SAME, 0, few).astype(np.uint8)
        self._frames.append((zlib.compress(few.tobytes(), 1), round(100 * seconds) * 10))

    def close(self) -> None:
        if not self._frames:
            return
        frames = self._images()
        self._file.create()
        next(frames).save(
            self._file.draft,
            "GIF",
            save_all=True,
            append_images=frames,
            palette=bytes(self._colours),
            transparency=_SAME,
            optimize=True,
            disposal=1,
            loop=0,
        )
        self._file.sync()
        self._file.rename()
        self._frames = []

    def drop(self) -> None:
        self._frames = []
        self._file.drop()

    def _images(self) -> Iterator[Image]:
        from PIL import Image

        for packed, milliseconds in self._frames:
            image = Image.frombytes("P", self._size, zlib.decompress(packed))
            image.putpalette(self._colours)
            image.info["duration"] = milliseconds
            yield image


def _colours(image: Image) -> list[int]:
    """The 256 different colours of a GIF as a flat list."""
    found = iter(image.quantize(_SAME - len(_STRONG)).getpalette() or [])
    chosen = list(dict.fromkeys([*_STRONG, *zip(found, found, found, strict=True)]))
    spare = (colour for colour in product((255, 0), (1, 254), range(256)) if colour not in chosen)
    return [part for colour in [*chosen, *islice(spare, _SAME + 1 - len(chosen))] for part in colour]


class _Mp4:
    """H.264 through the ffmpeg of the package imageio-ffmpeg."""

    def __init__(self, path: Path) -> None:
        if importlib.util.find_spec("imageio_ffmpeg") is None:
            raise Missing(
                "MP4 needs the package imageio-ffmpeg", "pip install 'lockprobe-robot[film]', or write a .gif"
            )
        self._file = Replacement(path)
        self._pipe: Generator[None, Any, None] | None = None
        self._owed = 0.0

    def add(self, picture: NDArray[np.uint8], seconds: float) -> None:
        if self._pipe is None:
            self._pipe = self._open(picture.shape[1], picture.shape[0])
        self._owed += seconds * RATES[".mp4"]
        while self._owed > 0.5:
            self._pipe.send(np.ascontiguousarray(picture))
            self._owed -= 1

    def close(self) -> None:
        if self._end_pipe():
            self._file.sync()
            self._file.rename()

    def drop(self) -> None:
        self._end_pipe()
        self._file.drop()

    def _end_pipe(self) -> bool:
        pipe, self._pipe = self._pipe, None
        if pipe is not None:
            pipe.close()
        return pipe is not None

    def _open(self, width: int, height: int) -> Generator[None, Any, None]:
        import imageio_ffmpeg

        self._file.create()
        pipe: Generator[None, Any, None] = imageio_ffmpeg.write_frames(
            str(self._file.draft),
            (width, height),
            fps=RATES[".mp4"],
            codec="libx264",
            quality=None,
            macro_block_size=2,
            ffmpeg_log_level="error",
            output_params=["-crf", "23", "-movflags", "+faststart"],
        )
        pipe.send(None)
        return pipe


class _Directory:
    """Numbered PNG files."""

    def __init__(self, path: Path) -> None:
        if path.exists() and (not path.is_dir() or any(path.iterdir())):
            raise BadFile(path, "is there and not an empty directory; choose another")
        self._path = path
        self._new: NewDirectory | None = None
        self._count = 0

    def add(self, picture: NDArray[np.uint8], seconds: float) -> None:
        self._new = self._new or NewDirectory(self._path)
        self._count += 1
        (self._new.draft / f"{self._count:05}.png").write_bytes(to_png(picture))

    def close(self) -> None:
        if self._new is not None:
            self._new.commit()

    def drop(self) -> None:
        if self._new is not None:
            self._new.drop()
