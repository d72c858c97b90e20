"""Reads joint positions from pictures of a fixed camera, as the truth where nobody types it.

A file gives the place of each handle in the picture at position 0 and at position 1. The cues are those of the agent
``viewer`` (:mod:`lockprobe.trial.pictures.picture_reader`) at full acuity. A reading without clear evidence is no
reading.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray
from PIL import ImageOps
from pydantic import Field, FiniteFloat

from lockprobe.boxes.box import Configuration, Lockbox, bits
from lockprobe.foundation.errors import BadFile, PlantFault
from lockprobe.foundation.inputs import read_toml
from lockprobe.foundation.validation import Written, validated
from lockprobe.plants.manual import ENTER, Manual, Operator, ask_to_begin
from lockprobe.trial.pictures.frame import Camera, Frame
from lockprobe.trial.pictures.picture_reader import clear_positions
from lockprobe.trial.record import Fact, Snapshot, in_words
from lockprobe_robot.hardware.bounds import call_driver
from lockprobe_robot.picture_file import open_picture

HANDLES_FILE = "handles.toml"
"""The file with the places of handles, in the folder of the pictures."""

_NEAREST = 8.0
"""Pixels between the two places of a handle, at least."""

_KINDS = (".png", ".jpg", ".jpeg")


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


class FolderCamera:
    """A camera that reads a folder in which a person, a phone or a webcam program saves pictures (PNG or JPEG).

    Each picture is used once: the newest file has to be new, or to have changed. BadFile is raised if it is no folder.
    """

    facts: ClassVar = {"camera": "folder"}

    def __init__(self, folder: Path | str) -> None:
        self._folder = Path(folder)
        if not self._folder.is_dir():
            raise BadFile(self._folder, "no such folder; a camera's pictures are expected there")
        self._used = self._newest()

    def grab(self) -> Shot:
        """The newest picture, rotated as its EXIF data say.

        Raises:
            PlantFault: If there is no new picture, or it cannot be read.
        """
        newest = self._newest()
        if newest is None or newest == self._used:
            raise PlantFault(f"there is no new picture in {self._folder} (PNG or JPEG)")
        path = newest[2]
        try:
            picture = open_picture(path)
        except BadFile as bad:
            raise PlantFault(str(bad)) from None
        self._used = newest
        return Shot(rgb=np.asarray(ImageOps.exif_transpose(picture).convert("RGB"), dtype=np.uint8))

    def _newest(self) -> tuple[int, int, Path] | None:
        """Modification time, size and path of the newest picture."""
        try:
            files = [path for path in self._folder.iterdir() if path.suffix.lower() in _KINDS and path.is_file()]
            known = [((stat := path.stat()).st_mtime_ns, stat.st_size, path) for path in files]
        except OSError as error:
            raise PlantFault(f"{self._folder} cannot be read ({error.strerror})") from None
        return max(known, default=None)


_Place = tuple[Annotated[FiniteFloat, Field(ge=0)], Annotated[FiniteFloat, Field(ge=0)]]


class HandlePlaces(Written):
    """The places of a handle: column and row in pixels from the top left, at position 0 and at position 1."""

    at_0: _Place
    at_1: _Place


class ImageHandles(Written):
    """The places of the handles in the pictures of a fixed camera.

    Attributes:
        width: Width of its pictures, pixels.
        height: Their height, pixels.
        joints: Joint -> the places of its handle, in panel order.
    """

    width: Annotated[int, Field(ge=64, le=4096)]
    height: Annotated[int, Field(ge=64, le=4096)]
    joints: dict[str, HandlePlaces]


def read_handles(path: Path, box: Lockbox) -> ImageHandles:
    """Read a TOML file of handles: ``width``, ``height``, and for each joint of the box ``at_0`` and ``at_1``.

    Raises:
        BadFile: If it cannot be read, a joint is missing or unknown, or a place lies outside the picture.
    """
    if not path.exists():
        raise BadFile(path, "no such file; it says where pictures show the handles (robot/docs/robot.md)")
    said = read_toml(path)
    given: dict[str, Any] = {name: said.pop(name) for name in ("width", "height") if name in said}
    if said.keys() != set(box.names):
        raise BadFile(path, f"got the joints {', '.join(said) or 'none'}, expected {', '.join(box.names)}")
    found = validated(ImageHandles, given | {"joints": {name: said[name] for name in box.names}}, path)
    for name, places in found.joints.items():
        if any(column >= found.width or row >= found.height for column, row in (places.at_0, places.at_1)):
            raise BadFile(path, f"{name}: a place outside {found.width} x {found.height} pixels")
        if math.dist(places.at_0, places.at_1) < _NEAREST:
            raise BadFile(path, f"{name}: at_0 and at_1 are nearer than {_NEAREST:g} pixels")
    return found


class Sight(Protocol):
    """Reads the positions of the joints from pictures, as the truth."""

    @property
    def facts(self) -> Mapping[str, Fact]:
        """Facts for the record, such as the kind of camera."""
        ...

    def read(self, names: tuple[str, ...]) -> Snapshot:
        """Take a new picture and read it; the joints have these names in panel order, for the message.

        With a ``PlantFault`` if there is none, or no clear position of a joint, the person is asked for another one.
        """
        ...

    def close(self) -> None:
        """Release the camera."""
        ...


class CameraSight:
    """Reads the positions of joints in the pictures of a camera; a :class:`Sight`."""

    def __init__(self, camera: HardwareCamera, handles: ImageHandles) -> None:
        self._camera, self._handles = camera, handles
        self.facts: Mapping[str, Fact] = dict(getattr(camera, "facts", {}))
        self._places = [(places.at_0, places.at_1) for places in handles.joints.values()]

    def read(self, names: tuple[str, ...]) -> Snapshot:
        """Take a picture and read it; ``names`` of the joints are for messages.

        Raises:
            PlantFault: If there is none, or a joint cannot be read.
        """
        shot = call_driver("the camera", self._camera.grab)
        rgb, wanted = shot.rgb, (self._handles.height, self._handles.width, 3)
        if rgb.shape != wanted or rgb.dtype != np.uint8 or (shot.depth is not None and shot.depth.shape != wanted[:2]):
            depth = "" if shot.depth is None else f", depth of {shot.depth.shape}"
            raise PlantFault(f"the camera gave {rgb.shape} of {rgb.dtype}{depth}, expected {wanted} of uint8")
        found = clear_positions(rgb, self._places)
        if unclear := [name for name, one in zip(names, found, strict=True) if one is None]:
            raise PlantFault(f"the picture does not show clearly where {', '.join(unclear)} stands")

        def look() -> Frame:
            width, height = self._handles.width, self._handles.height
            panel = np.eye(4)  # the camera's pose is not known, so the panel is the plane of the picture
            panel[2, 3] = 1.0
            flat = np.array(self._places, dtype=float) - ((width - 1) / 2, (height - 1) / 2)
            return Frame(
                rgb=rgb,
                depth=shot.depth if shot.depth is not None else np.zeros((height, width), dtype=np.float32),
                camera=Camera(width=width, height=height, focal=1.0, panel=panel),
                handles=np.concatenate([flat, np.zeros((*flat.shape[:2], 1))], axis=-1),
                renderer="camera",
            )

        return Snapshot(configuration=tuple(map(bool, found)), look=look)

    def close(self) -> None:
        """Release the camera, if it has something to release."""
        call_driver("the camera", getattr(self._camera, "close", lambda: None))


def only_moved(called: Sequence[str], joint: int, before: Configuration, after: Configuration) -> Configuration:
    """The configuration after an attempt on a joint, by index in panel order; ``PlantFault`` if another one moved."""
    others = [name for i, name in enumerate(called) if i != joint and before[i] != after[i]]
    if others:
        moved = f"{', '.join(others)} moved: {bits(before)} became {bits(after)}"
        raise PlantFault(f"{called[joint]} was attempted and {moved}")
    return after


class Photographed(Manual):
    """A box that a person moves and photographs: the truth is what a sight reads in the pictures."""

    def __init__(self, box: Lockbox, *, labels: tuple[str, ...], operator: Operator, sight: Sight) -> None:
        super().__init__(box, labels=labels, operator=operator)
        self._sight = sight

    @property
    def facts(self) -> Mapping[str, Fact]:
        """The source of the truth, and its own facts."""
        return {"truth": "camera", **self._sight.facts}

    def close(self) -> None:
        """Release the camera."""
        self._sight.close()

    def _begin(self) -> None:
        ask = "Take a picture, then press Enter; q to stop:"
        while (seen := self._seen(lambda: ask_to_begin(self._operator, ask))) != self._box.initial:
            places = zip(self._called, self._box.initial, seen, strict=True)
            wrong = ", ".join(f"{one} at {wanted:d}" for one, wanted, found in places if wanted != found)
            self._operator.tell(f"The picture shows {bits(seen)}: set {wrong}.")

    def _after(self, joint: int, before: Configuration, ask: str) -> Configuration:
        ask = f"{ask} if it goes. Take a picture, then press Enter; q to stop:"
        seen = self._seen(lambda: self._operator.ask(ask, (ENTER,)))
        after = only_moved(self._called, joint, before, seen)
        did = in_words(after[joint] != before[joint])
        self._operator.tell(f"The picture shows {bits(after)}: {self._called[joint]} {did}.")
        return after

    def _seen(self, ask: Callable[[], object]) -> Configuration:
        """Ask for a picture until one can be read."""
        while True:
            ask()
            try:
                seen = self._sight.read(self._called)
            except PlantFault as fault:
                self._operator.tell(f"{fault}.")
                continue
            self._look = seen.look
            return seen.configuration
