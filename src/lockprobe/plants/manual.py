"""The plant ``manual``: a person moves the joint that the agent names, and says what happened.

The truth is the person's answer, or with ``manual?camera=FOLDER`` the reading of a picture. The person sees the agent's
label and the name of the joint in the box. The plant needs a terminal, so its trials are played in this process, one at
a time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from lockprobe.errors import BadValue, PlantFault
from lockprobe.lockbox.box import Configuration, Lockbox, bits
from lockprobe.pictures.frame import Frame
from lockprobe.plants.hardware.camera import FolderCamera, HardwareCamera, Shot, check_shot
from lockprobe.plants.hardware.driver_call import call_driver
from lockprobe.plants.hardware.position_reader import (
    HANDLES_FILE,
    ImageHandles,
    Unclear,
    read_handles,
    read_positions,
)
from lockprobe.plants.operator import ENTER, Operator, TerminalOperator, ask_to_begin
from lockprobe.record import Fact, Snapshot

__all__ = ["Manual", "ManualSettings", "check_manual", "make_manual"]

WEBCAM = "webcam"


@dataclass(frozen=True, slots=True, kw_only=True)
class ManualSettings:
    """The options of ``manual``.

    Attributes:
        camera: A folder in which pictures are saved, or ``webcam``; empty for a person who types what happened.
        handles: The file with the places of handles in pictures; by default ``handles.toml``, in the folder or, with
            a webcam, in the working directory.
        device: Number of the webcam.

    Raises:
        BadValue: If an option has no effect in this combination.
    """

    camera: str = ""
    handles: str = ""
    device: int = 0

    def __post_init__(self) -> None:
        if self.handles and not self.camera:
            raise BadValue("handles", self.handles, "camera=FOLDER or camera=webcam with it")
        if not 0 <= self.device <= 63:
            raise BadValue("device", self.device, "a whole number from 0 to 63")

    @property
    def handles_file(self) -> Path:
        """Path of the file with the places of handles."""
        if self.handles:
            return Path(self.handles)
        return Path(HANDLES_FILE) if self.camera == WEBCAM else Path(self.camera) / HANDLES_FILE

    def open_camera(self) -> HardwareCamera:
        """Open the camera.

        Raises:
            UserMistake: If it is missing.
        """
        if self.camera == WEBCAM:
            from lockprobe.plants.hardware.webcam import Webcam

            return Webcam(self.device)
        return FolderCamera(self.camera)


def make_manual(settings: ManualSettings, box: Lockbox, labels: tuple[str, ...]) -> Manual:
    """The plant for one trial, with the terminal as its operator.

    Raises:
        UserMistake: If there is no camera, or its file of handles does not fit the box.
    """
    handles = read_handles(settings.handles_file, box) if settings.camera else None
    camera = settings.open_camera() if settings.camera else None
    return Manual(box, labels=labels, operator=TerminalOperator(), camera=camera, handles=handles)


def check_manual(settings: ManualSettings, box: Lockbox) -> None:
    """Check the camera and its file of handles before the first trial. Raises as :func:`make_manual`."""
    make_manual(settings, box, box.names).close()


class Manual:
    """A box in front of a person.

    The trial begins when the person says that the box stands in its initial configuration.

    Args:
        box: The box. Its rules only detect typing errors; they decide no outcome.
        labels: Labels of the joints, in panel order.
        operator: The person.
        camera: Takes the picture that tells the truth; None if the person tells it.
        handles: The places of the handles in its pictures; required with a camera, else None.
    """

    def __init__(
        self,
        box: Lockbox,
        *,
        labels: tuple[str, ...],
        operator: Operator,
        camera: HardwareCamera | None = None,
        handles: ImageHandles | None = None,
    ) -> None:
        assert (camera is None) == (handles is None)
        self._box, self._operator, self._camera, self._handles = box, operator, camera, handles
        self._called = [f"{label} ({name})" for label, name in zip(labels, box.names, strict=True)]
        self._configuration: Configuration | None = None
        self._shot: Shot | None = None

    @property
    def facts(self) -> Mapping[str, Fact]:
        """The source of the truth."""
        if self._camera is None:
            return {"truth": "person"}
        return {"truth": "camera", **getattr(self._camera, "facts", {})}

    def observe(self) -> Snapshot:
        """The truth now; before the first attempt the person is asked to set the box up.

        Raises:
            UserMistake: If the person stops here: no trial has begun.
        """
        if self._configuration is None:
            self._set_up()
        assert self._configuration is not None
        return Snapshot(configuration=self._configuration, look=self._look())

    def attempt(self, joint: int) -> Snapshot:
        """Let the person attempt a joint, by index in panel order.

        Raises:
            OperatorStopped: If the person stops, or the input ends.
            PlantFault: If the picture shows that another joint moved.
        """
        before = self._configuration
        assert before is not None
        ends = f"from {before[joint]:d} to {not before[joint]:d}"
        if self._camera is None:
            after = self._typed(joint, before, ends)
        else:
            after = self._photographed(
                f"Move joint {self._called[joint]} {ends} if it goes. Take a picture, then press Enter; q to stop:",
                lambda seen: "",
            )
            others = [i for i, (was, now) in enumerate(zip(before, after, strict=True)) if was != now and i != joint]
            if others:
                moved = ", ".join(self._called[i] for i in others)
                states = f"{bits(before)} became {bits(after)}"
                raise PlantFault(f"{self._called[joint]} was attempted and {moved} moved: {states}")
            did = "moved" if after[joint] != before[joint] else "did not move"
            self._operator.tell(f"The picture shows {bits(after)}: {self._called[joint]} {did}.")
        self._configuration = after
        obeyed = after == self._box.attempt(before, joint)[0]
        return Snapshot(
            configuration=after,
            joint=joint,
            outcome="moved" if after[joint] != before[joint] else "blocked",
            sensed={"truth": "person" if self._camera is None else "camera", "as_rules": obeyed},
            look=self._look(),
        )

    def close(self) -> None:
        """Release the camera."""
        release = getattr(self._camera, "close", None)
        if release is not None:
            release()

    def _set_up(self) -> None:
        """Ask the person to set the initial configuration, and verify it."""
        initial = self._box.initial
        stand = ", ".join(f"{called} at {at:d}" for called, at in zip(self._called, initial, strict=True))
        self._operator.tell(f"New trial of {self._box.name}. Set the joints: {stand}.")
        if self._camera is None:
            ask_to_begin(self._operator)
        else:
            self._photographed("Take a picture, then press Enter; q to stop:", self._wrongly_set, begin=True)
        self._configuration = initial

    def _wrongly_set(self, seen: Configuration) -> str:
        """The joints in a wrong position, in words; empty if all are right."""
        wrong = [
            f"{called} at {wanted:d}"
            for called, wanted, found in zip(self._called, self._box.initial, seen, strict=True)
            if wanted != found
        ]
        return f"The picture shows {bits(seen)}: set {', '.join(wrong)}." if wrong else ""

    def _typed(self, joint: int, before: Configuration, ends: str) -> Configuration:
        """Ask what happened; an answer that violates the rules is confirmed by asking again."""
        called, rule = self._called[joint], self._box.may_move(before, joint)
        moved = self._operator.ask(f"Move joint {called} {ends}. Did it move? y/n, q to stop:", ("y", "n")) == "y"
        if moved != rule:
            says = "free" if rule else "locked"
            again = f"By the rules of {self._box.name} {called} is {says}. Did it really move? y/n, q to stop:"
            moved = self._operator.ask(again, ("y", "n")) == "y"
        return tuple(at != (moved and i == joint) for i, at in enumerate(before))

    def _photographed(
        self, question: str, complaint: Callable[[Configuration], str], *, begin: bool = False
    ) -> Configuration:
        """Ask for a picture until one can be read and passes the check."""
        assert self._camera is not None
        assert self._handles is not None
        while True:
            if begin:
                ask_to_begin(self._operator, question)
            else:
                self._operator.ask(question, (ENTER,))
            try:
                shot = check_shot(call_driver("the camera", self._camera.grab), self._handles.size)
                seen = read_positions(shot, self._handles.places, tuple(self._called))
            except (PlantFault, Unclear) as fault:
                self._operator.tell(f"{fault}.")
                continue
            if wrong := complaint(seen):
                self._operator.tell(wrong)
                continue
            self._shot = shot
            return seen

    def _look(self) -> Callable[[], Frame] | None:
        """A function that returns the picture of this moment."""
        if self._shot is None or self._handles is None:
            return None
        handles, shot = self._handles, self._shot
        return lambda: handles.frame(shot)
