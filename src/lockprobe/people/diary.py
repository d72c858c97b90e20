"""Diaries on disk: who joined, with the record of consent, and every act of each participant.

Each participant has one file, ``people/ID.jsonl``, with one line per act, so that all data of one person can be
deleted. The server flushes a line to disk before the page sees the outcome. Steps of an unfinished trial are only
here. A finished trial goes to ``trials.jsonl`` like any other; its response times stay in the diary.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import closing
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, TypeAdapter

from lockprobe.agents.participant import check_participant, participant_spec
from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.foundation.spec import PEOPLE
from lockprobe.foundation.storage.atomic_file import sync_directory, write_private, writing
from lockprobe.foundation.storage.jsonl import (
    LineFile,
    read_values,
    state_of,
    with_checksum,
)
from lockprobe.foundation.storage.links import make_directory
from lockprobe.people.responses import Act, Attempt
from lockprobe.people.scenes import StrictModel
from lockprobe.studies.file_names import PEOPLE_DIRECTORY
from lockprobe.studies.study import Study
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Ending

Seconds = Annotated[float, Field(ge=0, allow_inf_nan=False)]
"""Since 1970 (UTC), of the server's clock."""


class Slot(StrictModel):
    """A trial of the study that a participant plays. Each trial of ``participant`` is played by one person."""

    condition: str
    repetition: int
    trial: int

    def plan(self, study: Study, identity: str) -> Plan:
        """The trial as a participant plays it.

        Raises:
            UnknownName: If the study has no such condition.
        """
        return study.plan(participant_spec(identity), study.labelled(self.condition), self.repetition, self.trial)


class Joined(StrictModel):
    """The first line: the record of consent.

    Attributes:
        identity: A random ID, independent of the person.
        token: SHA-256 of the browser's token; empty in an imported diary.
        at: When the participant agreed.
        platform: The parameters of the recruitment platform that the experimenter keeps.
        slots: The trials in the order in which they are played.
        words: Language and fingerprint of the texts, for example ``en 3f9a01bc22d1``.
    """

    kind: Literal["joined"] = "joined"
    identity: str
    token: str
    at: Seconds
    platform: dict[str, str]
    slots: tuple[Slot, ...]
    words: str


class Did(StrictModel):
    """One act.

    Attributes:
        at: When the server received it.
        turn: The number of the scene, from 2; joining was 1.
        scene: The kind of scene.
        box: The box of a step or of the scene after a box, from 1; 0 is the practice box.
        step: The step, from 1.
        told: The report that the step produced; empty with pictures.
        item: The number of a page, a check or a round of comprehension questions, from 1; the name of a question.
        right: Whether the answer to an attention check was right, or all answers of a round.
        ended: How the trial ended with this step; None where it goes on.
        page: Version of the page, with the first step of a box; empty for the practice box.
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


class Broken(StrictModel):
    """A box cannot be continued: it broke before a choice, or an import brought its finished trial.

    The participant goes on with the next scene.
    """

    kind: Literal["broken"] = "broken"
    at: Seconds
    turn: int
    box: int


class Released(StrictModel):
    """The last line of a participant who cannot go on: others may play the unfinished trials.

    ``why``: ``late`` (was away too long, and somebody else needed the place) or ``screened`` (too many rounds of wrong
    answers about the instructions).
    """

    kind: Literal["released"] = "released"
    at: Seconds
    why: Literal["late", "screened"] = "late"


Entry = Joined | Did | Broken | Released

_adapter: TypeAdapter[Entry] = TypeAdapter(Annotated[Entry, Field(discriminator="kind")])


class DiaryFile:
    """Appends to the diary of one participant. The file is open only while a line is written.

    The line ``joined`` creates the file. Every other line needs the file as this process left it.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._left = state_of(path)

    def write(self, line: Entry) -> None:
        """Append a line and flush it to disk.

        Raises:
            BadFile: If it cannot be written, the diary does not exist, or another process has changed it. The file then
                holds nothing of the line.
        """
        new = isinstance(line, Joined)
        if not new and not self.path.exists():  # one that was deleted in the meantime does not come back
            raise BadFile(self.path, "does not exist")
        with writing(self.path):
            if new:
                make_directory(self.path.parent, mode=0o700)
            with closing(LineFile(self.path, left=self._left, rescue=False)) as file:
                file.check()
                file.cut_torn_tail()
                if new:
                    sync_directory(self.path.parent)
                file.append(with_checksum(_adapter.dump_json(line, exclude_defaults=False)), sync=True)
                self._left = file.left


@dataclass(frozen=True, slots=True)
class Diary:
    """The diary of one participant as read from disk: its first line, and the other lines, oldest first."""

    joined: Joined
    lines: tuple[Did | Broken | Released, ...]

    @property
    def identity(self) -> str:
        """The ID of the participant."""
        return self.joined.identity

    @property
    def spec(self) -> str:
        """The agent of the trials."""
        return participant_spec(self.identity)

    @property
    def acts(self) -> tuple[Did, ...]:
        """What the participant did, oldest first."""
        return tuple(line for line in self.lines if isinstance(line, Did))

    def attempts(self, box: int) -> tuple[Did, ...]:
        """The steps of a box, oldest first."""
        return tuple(act for act in self.acts if act.box == box and isinstance(act.act, Attempt))

    def times(self, box: int) -> tuple[float, float]:
        """When a box was first shown and when its last step arrived, seconds since 1970."""
        steps = self.attempts(box)
        shown = (before.at for before, line in pairwise((self.joined, *self.lines)) if line is steps[0])
        return next(shown), steps[-1].at

    def check_slots(self, study: Study, directory: Path) -> None:
        """Refuse trials that the study does not have.

        Raises:
            BadFile: If the participant plays such a trial.
        """
        for slot in self.joined.slots:
            there = 1 <= slot.repetition <= study.repetitions and 1 <= slot.trial <= study.trials
            if not (there and slot.condition in [one.label for one in study.conditions_of(PEOPLE)]):
                raise BadFile(diary_path(directory, self.identity), "trials of another study")


def diary_path(directory: Path, identity: str) -> Path:
    """The path of a participant's diary in the directory of a study."""
    return directory / PEOPLE_DIRECTORY / f"{identity}.jsonl"


def without_identity(diary: Diary, *, platform: bool = False) -> Diary:
    """A copy of a diary to share: no token, no platform parameters unless ``platform``, no time of day.

    Times are seconds since this participant joined, to the millisecond.
    """
    start = diary.joined.at
    joined = diary.joined.model_copy(
        update={"token": "", "at": 0.0, "platform": diary.joined.platform if platform else {}}
    )
    lines = (line.model_copy(update={"at": round(max(0.0, line.at - start), 3)}) for line in diary.lines)
    return Diary(joined, tuple(lines))


def read_diaries(directory: Path | str) -> list[Diary]:
    """The diaries of a study in the order in which the participants joined.

    Raises:
        BadFile: If a diary is damaged or a link, or the name of its file is not its participant.
    """
    people = Path(directory) / PEOPLE_DIRECTORY
    return sorted(_diaries(people), key=lambda diary: (diary.joined.at, diary.identity))


def read_diary(path: Path) -> list[Entry]:
    """The lines of one diary, without an unfinished last line.

    Raises:
        BadFile: If a line is damaged, or the first is not ``joined``.
    """
    found = list(read_values(path, _adapter))
    if found and not isinstance(found[0], Joined):
        raise BadFile(path, "line 1: names no participant")
    return found


def _diaries(people: Path) -> Iterator[Diary]:
    if people.is_symlink():
        raise BadFile(people, "a link, not a directory")
    for path in sorted(people.glob("*.jsonl")):
        if path.is_symlink() or not path.is_file():
            raise BadFile(path, "a diary must be a regular file, not a link")
        lines = read_diary(path)
        if not lines:
            continue
        joined, *rest = lines
        assert isinstance(joined, Joined)
        try:
            check_participant(participant_spec(joined.identity))
        except BadValue as mistake:
            raise BadFile(path, str(mistake)) from None
        if path.name != f"{joined.identity}.jsonl":
            raise BadFile(path, f"the diary of another participant, {joined.identity}")
        then = tuple(line for line in rest if not isinstance(line, Joined))
        if len(then) < len(rest):
            raise BadFile(path, "the participant joins twice")
        turns = [line.turn for line in then if not isinstance(line, Released)]
        if turns != list(range(2, 2 + len(turns))):
            raise BadFile(path, "an act is missing or duplicated")
        yield Diary(joined, then)


def make_private(directory: Path) -> None:
    """Let nobody but this user read the directory of a study in which people take part, nor what is in it."""
    with writing(directory):
        directory.chmod(0o700)


def write_diaries(directory: Path, diaries: Iterable[Diary]) -> None:
    """Write diaries into the directory of a study, each file atomically.

    Raises:
        BadFile: If a diary cannot be written.
    """
    for diary in diaries:
        lines = (with_checksum(line.model_dump_json().encode()) for line in (diary.joined, *diary.lines))
        content = b"".join(line + b"\n" for line in lines)
        write_private(diary_path(directory, diary.identity), content)
