"""A camera in front of a box that a person moves: ``manual?camera=FOLDER``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from lockprobe.boxes.box import Lockbox
from lockprobe.foundation.errors import BadValue, PlantFault
from lockprobe.foundation.spec import in_words
from lockprobe.plants.manual import Manual, Seen
from lockprobe.plants.operator import TerminalOperator
from lockprobe.trial.record import Fact
from lockprobe_robot.hardware.camera import FolderCamera, HardwareCamera, check_shot
from lockprobe_robot.hardware.driver_call import call_driver
from lockprobe_robot.hardware.manual_scene import ManualScene
from lockprobe_robot.hardware.position_reader import (
    HANDLES_FILE,
    ImageHandles,
    Unclear,
    read_handles,
    read_positions,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class ManualSettings(ManualScene):
    """The options of ``manual``; those of the scene need a camera.

    Attributes:
        camera: A folder in which pictures are saved; empty for a person who types what happened.
        handles: The file with the places of handles in pictures of the plain viewpoint; by default ``handles.toml`` in
            the folder.

    Raises:
        BadValue: If an option has no effect in this combination.
    """

    camera: str = ""
    handles: str = ""

    def __post_init__(self) -> None:
        ManualScene.__post_init__(self)
        plain = {"handles": "", **ManualScene().levels}
        for name, level in {"handles": self.handles, **self.levels}.items():
            if level != plain[name] and not self.camera:
                raise BadValue(name, in_words(level), "camera=FOLDER with it")

    @property
    def handles_file(self) -> Path:
        """Path of the file with the places of handles from the viewpoint: that of another one has its name behind."""
        file = Path(self.handles) if self.handles else Path(self.camera) / HANDLES_FILE
        return file if self.viewpoint == "plain" else file.with_stem(f"{file.stem}-{self.viewpoint}")


class CameraSight:
    """Reads the positions of joints in the pictures of a camera; a :class:`lockprobe.plants.manual.Sight`.

    Args:
        camera: The camera.
        handles: The places of the handles in its pictures.
        scene: What the camera sees, as the person is asked to set it up.
    """

    def __init__(self, camera: HardwareCamera, handles: ImageHandles, scene: ManualScene | None = None) -> None:
        self._camera, self._handles, self._scene = camera, handles, scene or ManualScene()

    @property
    def facts(self) -> Mapping[str, Fact]:
        """The facts of the camera, and the scene."""
        found: Mapping[str, Fact] = getattr(self._camera, "facts", {})
        return {**found, **self._scene.levels}

    @property
    def scene(self) -> str:
        """What the person is asked to set up before a trial."""
        return self._scene.instruction

    def read(self, names: tuple[str, ...]) -> Seen:
        """Take a picture and read it.

        Raises:
            PlantFault: If there is none, or a joint cannot be read.
        """
        handles, shot = self._handles, check_shot(call_driver("the camera", self._camera.grab), self._handles.size)
        try:
            configuration = read_positions(shot, handles.places, names)
        except Unclear as unclear:
            raise PlantFault(str(unclear)) from None
        return Seen(configuration=configuration, look=lambda: replace(handles.frame(shot), labelled=self._scene.labels))

    def close(self) -> None:
        """Release the camera, if it has something to release."""
        release = getattr(self._camera, "close", None)
        if release is not None:
            release()


def make_manual(settings: ManualSettings, box: Lockbox, labels: tuple[str, ...]) -> Manual:
    """The plant for one trial, with the terminal as its operator.

    Raises:
        UserMistake: If there is no camera, or its file of handles does not fit the box.
    """
    sight = None
    if settings.camera:
        handles = read_handles(settings.handles_file, box)
        sight = CameraSight(FolderCamera(settings.camera), handles, settings)
    return Manual(box, labels=labels, operator=TerminalOperator(), sight=sight)


def check_manual(settings: ManualSettings, box: Lockbox) -> None:
    """Check the camera and its file of handles before the first trial. Raises as :func:`make_manual`."""
    make_manual(settings, box, box.names).close()
