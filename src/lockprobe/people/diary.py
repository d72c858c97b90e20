"""What participants did, on disk: one file for each, ``people/ID.jsonl``, one line an act.

A line is on the disk itself before the page sees what came of it. A trial that is under way stands here; when it is
over its record goes to ``trials.jsonl`` like any other, and its times stay here. One file each, so that all that is
kept of one person can be deleted.
"""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from lockprobe.errors import BadFile, BadValue
from lockprobe.people.responses import Act
from lockprobe.record import Ending
from lockprobe.storage.atomic_file import sync_directory
from lockprobe.storage.jsonl import LineFile, state_of, whole_lines, with_checksum, without_checksum
from lockprobe.studies.directory import PEOPLE_DIRECTORY

__all__ = [
    "PEOPLE_DIRECTORY",
    "Broken",
    "Diary",
    "Did",
    "Entry",
    "Joined",
    "Line",
    "Released",
    "Slot",
    "read_diary",
]

Seconds = Annotated[float, Field(ge=0, allow_inf_nan=False)]
"""Since 1970 (UTC), of the server's clock."""


class _Line(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class Slot(_Line):
    """Which trial of the study a participant plays; people play the trials of ``participant`` together, each once.

    Attributes:
        p: Flip probability, [0, 1].
        modality: How the box is shown, as its spec.
        repetition: From 1.
        trial: From 1.
    """

    p: float
    modality: str
    repetition: int
    trial: int


class Joined(_Line):
    """The first line: somebody has agreed to take part.

    Attributes:
        identity: Made up here; no part of it comes from the person.
        token: SHA-256 of what the browser shows as proof that it is the same.
        at: When.
        platform: What the recruitment platform said, as far as the experimenter asked for it.
        slots: The trials, in the order in which they are played.
        words: Language and fingerprint of the texts that were read, for example ``en 3f9a01bc22d1``.
    """

    kind: Literal["joined"] = "joined"
    identity: str
    token: str
    at: Seconds
    platform: dict[str, str]
    slots: tuple[Slot, ...]
    words: str


class Did(_Line):
    """One act.

    Attributes:
        at: When it came.
        turn: The number of the scene, from 2; every participant's acts count up by one, and joining is the first.
        scene: What kind of scene it was.
        act: What was done.
        box: Of a step and of the scene after a box: which box, from 1; 0 is the practice box.
        step: Of a step: which, from 1.
        told: Of a step: the report that was then shown; empty with pictures.
        item: Of a page or a check: which, from 1; of a question its name.
        right: Of a check: whether the answer was right.
        ended: Of a step: how the trial ended with it; None where it goes on.
        page: Of the first step of a box: version of the page on which it is played; empty for the practice box.
    """

    kind: Literal["did"] = "did"
    at: Seconds
    turn: int
    scene: str
    act: Act
    box: int | None = None
    step: int | None = None
    told: str = ""
    item: str = ""
    right: bool | None = None
    ended: Ending | None = None
    page: str = ""


class Broken(_Line):
    """A box cannot be played on: it broke before a joint could be chosen, or the trial came from elsewhere, finished.

    The participant goes on with what comes after it.
    """

    kind: Literal["broken"] = "broken"
    at: Seconds
    turn: int
    box: int


class Released(_Line):
    """The last line, where a participant was away too long: the trials that were not finished are others' now."""

    kind: Literal["released"] = "released"
    at: Seconds


Entry = Joined | Did | Broken | Released

Line = Annotated[Entry, Field(discriminator="kind")]

_adapter: TypeAdapter[Entry] = TypeAdapter(Line)


class Diary:
    """The file of one participant, open only while a line is written.

    The line of who joins makes it; every other line needs one that is there, as this process left it.

    Args:
        path: Where it lies.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._left = state_of(path)

    def write(self, line: Entry) -> None:
        """Put a line on the disk itself.

        Raises:
            BadFile: If it cannot be written, there is no diary of whoever it is about, or somebody else has changed it;
                then nothing of it is there.
        """
        new = isinstance(line, Joined)
        if not new and not self.path.exists():  # one that was deleted in the meantime does not come back
            raise BadFile(self.path, "is not there")
        try:
            if new:
                self.path.parent.mkdir(mode=0o700, exist_ok=True)
            with closing(LineFile(self.path, left=self._left, rescue=False)) as file:
                file.check()
                file.cut_torn_tail()
                if new:
                    sync_directory(self.path.parent)
                file.append(with_checksum(_adapter.dump_json(line, exclude_defaults=False)), sync=True)
                self._left = file.left
        except OSError as error:
            raise BadFile(self.path, f"cannot be written ({error.strerror})") from error


def read_diary(path: Path) -> list[Entry]:
    """The lines of one participant; an unfinished last line is none.

    Raises:
        BadFile: If a line is damaged, or the first does not say who it is.
    """
    found: list[Entry] = []
    for number, line in whole_lines(path):
        try:
            found.append(_adapter.validate_json(without_checksum(line)))
        except ValidationError as error:
            raise BadFile(path, f"line {number}: {error.errors()[0]['msg']}") from None
        except BadValue as error:
            raise BadFile(path, f"line {number}: {error}") from None
    if found and not isinstance(found[0], Joined):
        raise BadFile(path, "line 1: does not say who takes part")
    return found
