"""Cameras as the hardware plants use them: any object with ``grab()``. Here: a folder that pictures are saved to."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lockprobe.errors import BadFile, PlantFault, needing

__all__ = ["FolderCamera", "HardwareCamera", "Shot", "check_shot"]

_KINDS = (".png", ".jpg", ".jpeg")
_MOST_PIXELS = 4096 * 4096
"""The largest picture; those of plants have the same limit."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Shot:
    """One picture of a camera.

    Attributes:
        rgb: Shape (height, width, 3), 0 to 255.
        depth: Shape (height, width), metres along the optical axis, 0 where there is no reading; None without a depth
            sensor.
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32] | None = None


class HardwareCamera(Protocol):
    """Takes pictures. A class may add ``close()``, and ``facts`` for the record."""

    def grab(self) -> Shot:
        """The scene now.

        Raises:
            PlantFault: If there is no picture. Any other exception counts as one.
        """
        ...


def check_shot(shot: Shot, size: tuple[int, int] | None = None) -> Shot:
    """The shot, if its arrays have the shapes that they should have.

    Args:
        shot: As a camera gave it.
        size: Width and height, pixels, that it must have; None for any.

    Raises:
        PlantFault: If they have not.
    """
    rgb, depth = shot.rgb, shot.depth
    if rgb.ndim != 3 or rgb.shape[2] != 3 or rgb.dtype != np.uint8:
        raise PlantFault(f"the camera gave {rgb.shape} of {rgb.dtype}, expected height x width x 3 of uint8")
    if depth is not None and depth.shape != rgb.shape[:2]:
        raise PlantFault(f"the camera gave depth of {depth.shape} with colours of {rgb.shape[:2]}: align them")
    found = (rgb.shape[1], rgb.shape[0])
    if size is not None and found != size:
        raise PlantFault(f"a picture has {found[0]} x {found[1]} pixels, expected {size[0]} x {size[1]}")
    return shot


class FolderCamera:
    """A folder in which a person, a phone or a webcam program saves pictures (PNG or JPEG).

    A picture is used once: the newest file has to be another one than before, or to have changed.

    Args:
        folder: The folder.

    Raises:
        BadFile: If it is no folder.
        Missing: If Pillow is not installed.
    """

    def __init__(self, folder: Path | str) -> None:
        self._folder = Path(folder)
        with needing("cameras", "twin"):
            import PIL  # noqa: F401 - a missing package is said before the first trial
        if not self._folder.is_dir():
            raise BadFile(self._folder, "no such folder; a camera's pictures are expected there")
        self._used = self._newest()

    @property
    def facts(self) -> dict[str, str]:
        """What it is."""
        return {"camera": "folder"}

    def grab(self) -> Shot:
        """The newest picture.

        Raises:
            PlantFault: If there is no new one, or it cannot be read.
        """
        newest = self._newest()
        if newest is None or newest == self._used:
            raise PlantFault(f"there is no new picture in {self._folder} (PNG or JPEG)")
        shot = Shot(rgb=_read(newest[2]))
        self._used = newest
        return shot

    def _newest(self) -> tuple[int, int, Path] | None:
        """Modification time, size and path of the newest picture."""
        try:
            files = [path for path in self._folder.iterdir() if path.suffix.lower() in _KINDS and path.is_file()]
            known = [((stat := path.stat()).st_mtime_ns, stat.st_size, path) for path in files]
        except OSError as error:
            raise PlantFault(f"{self._folder} cannot be read ({error.strerror})") from None
        return max(known, default=None)


def _read(path: Path) -> NDArray[np.uint8]:
    """Colours of a file, turned as viewers show it."""
    from PIL import Image, ImageOps

    try:
        with Image.open(path, formats=["PNG", "JPEG"]) as image:
            if image.width * image.height > _MOST_PIXELS:
                raise PlantFault(f"{path} has {image.width} x {image.height} pixels, at most {_MOST_PIXELS} are read")
            return np.asarray(ImageOps.exif_transpose(image).convert("RGB"), dtype=np.uint8)
    except (Image.DecompressionBombError, OSError, SyntaxError, ValueError):
        raise PlantFault(f"{path} is no whole PNG or JPEG picture") from None
