"""The interface of cameras for hardware plants (``grab()``), and a camera that reads a folder of pictures."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadFile, PlantFault, needing

_KINDS = (".png", ".jpg", ".jpeg")
_MOST_PIXELS = 4096 * 4096
"""The largest picture; those of plants have the same limit."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Shot:
    """One picture of a camera: colours, and depth if the camera measures it.

    Attributes:
        rgb: Shape (height, width, 3), 0 to 255.
        depth: Shape (height, width), metres along the optical axis, 0 where there is no reading; None without a depth
            sensor.
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32] | None = None


class HardwareCamera(Protocol):
    """The interface of a camera. A class may add ``close()``, and ``facts`` for the record."""

    def grab(self) -> Shot:
        """Take a picture of the scene now.

        Raises:
            PlantFault: If there is no picture. Any other exception counts as a ``PlantFault``.
        """
        ...


def check_shot(shot: Shot, size: tuple[int, int] | None = None) -> Shot:
    """Check the shapes of a shot's arrays, and return the shot.

    Args:
        shot: The shot of a camera.
        size: Required width and height, pixels; None for any.

    Raises:
        PlantFault: If a shape is wrong.
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
    """A camera that reads a folder in which a person, a phone or a webcam program saves pictures (PNG or JPEG).

    Each picture is used once: the newest file has to be new, or to have changed.

    Args:
        folder: The folder.

    Raises:
        BadFile: If it is not a folder.
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
        """The kind of camera, for the record."""
        return {"camera": "folder"}

    def grab(self) -> Shot:
        """The newest picture.

        Raises:
            PlantFault: If there is no new picture, or it cannot be read.
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
    """The colours of a picture file, rotated as its EXIF data say."""
    from PIL import Image, ImageOps

    try:
        with Image.open(path, formats=["PNG", "JPEG"]) as image:
            if image.width * image.height > _MOST_PIXELS:
                raise PlantFault(f"{path} has {image.width} x {image.height} pixels, at most {_MOST_PIXELS} are read")
            return np.asarray(ImageOps.exif_transpose(image).convert("RGB"), dtype=np.uint8)
    except (Image.DecompressionBombError, OSError, SyntaxError, ValueError):
        raise PlantFault(f"{path} is no whole PNG or JPEG picture") from None
