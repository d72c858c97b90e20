"""All that is kept of participants beside their trials: their diaries, read whole and written whole."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from lockprobe.agents.participant import check_participant, participant_spec
from lockprobe.errors import BadFile, BadValue
from lockprobe.people.diary import PEOPLE_DIRECTORY, Broken, Did, Joined, Released, read_diary
from lockprobe.storage.atomic_file import write_private
from lockprobe.storage.jsonl import with_checksum
from lockprobe.studies.study import Study

__all__ = ["Kept", "kept_diaries", "write_diaries"]


@dataclass(frozen=True, slots=True)
class Kept:
    """All that is kept of one participant beside the trials.

    Attributes:
        joined: Who.
        lines: What came then, oldest first.
    """

    joined: Joined
    lines: tuple[Did | Broken | Released, ...]

    @property
    def acts(self) -> tuple[Did, ...]:
        """What was done, oldest first."""
        return tuple(line for line in self.lines if isinstance(line, Did))

    @property
    def over(self) -> frozenset[int]:
        """The boxes that have nothing more to come, from 1; all where the places were given to others."""
        if any(isinstance(line, Released) for line in self.lines):
            return frozenset(range(1, len(self.joined.slots) + 1))
        ended = {act.box for act in self.acts if act.ended is not None and act.box is not None}
        return frozenset(ended | {line.box for line in self.lines if isinstance(line, Broken)}) - {0}

    def check_slots(self, study: Study, directory: Path) -> None:
        """Refuse somebody who plays trials that the study does not have.

        Raises:
            BadFile: If they do.
        """
        for slot in self.joined.slots:
            there = 1 <= slot.repetition <= study.repetitions and 1 <= slot.trial <= study.trials
            if not (there and slot.p in study.p and slot.modality in study.modalities):
                raise BadFile(directory / PEOPLE_DIRECTORY / f"{self.joined.identity}.jsonl", "trials of another study")

    @property
    def spec(self) -> str:
        """The agent of the trials."""
        return participant_spec(self.joined.identity)


def kept_diaries(directory: Path) -> list[Kept]:
    """The diaries of a study in the order in which the participants joined.

    Raises:
        BadFile: If one is damaged or no file of its own, or its file bears another name than the participant.
    """
    return sorted(_kept(directory), key=lambda kept: (kept.joined.at, kept.joined.identity))


def _kept(directory: Path) -> Iterator[Kept]:
    people = directory / PEOPLE_DIRECTORY
    if people.is_symlink():
        raise BadFile(people, "a link, not a directory of its own")
    for path in sorted(people.glob("*.jsonl")):
        if path.is_symlink() or not path.is_file():
            raise BadFile(path, "a diary has to be a file of its own")
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
            raise BadFile(path, "somebody joins twice")
        turns = [line.turn for line in then if not isinstance(line, Released)]
        if turns != list(range(2, 2 + len(turns))):
            raise BadFile(path, "an act is missing, or stands there twice")
        yield Kept(joined, then)


def write_diaries(directory: Path, diaries: Iterable[Kept]) -> None:
    """Put diaries into the directory of a study, each whole or not at all.

    Raises:
        BadFile: If one cannot be written.
    """
    people = directory / PEOPLE_DIRECTORY
    for kept in diaries:
        lines = (with_checksum(line.model_dump_json().encode()) for line in (kept.joined, *kept.lines))
        content = b"".join(line + b"\n" for line in lines)
        write_private(people / f"{kept.joined.identity}.jsonl", content)
