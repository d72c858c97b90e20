"""Imports diaries that were written elsewhere into the directory of a study."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.inputs import read_input
from lockprobe.foundation.storage.atomic_file import write_private
from lockprobe.people.diary import Diary, make_private, read_diaries, write_diaries
from lockprobe.people.experiment import EXPERIMENT
from lockprobe.people.texts import TEXTS
from lockprobe.studies.file_names import PEOPLE_DIRECTORY
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.journal import Journal


def coming_diaries(directory: Path, sources: Iterable[Path]) -> list[Diary]:
    """The diaries of other directories that are new in this one, or longer than here.

    Tokens do not come along, so participants who began elsewhere cannot resume here.

    Raises:
        BadFile: If a diary is damaged, or two participants have the same ID.
    """
    known = {diary.identity: diary for diary in read_diaries(directory)}
    coming = dict[str, Diary]()
    for source in sources:
        for diary in read_diaries(source):
            diary.check_slots(read_study(source), source)
            here = known.get(diary.identity)
            joined = here.joined if here else diary.joined.model_copy(update={"token": ""})
            if here is not None:
                common = min(len(here.lines), len(diary.lines))
                alike = (here.joined.slots, here.joined.words) == (diary.joined.slots, diary.joined.words)
                if not alike or here.lines[:common] != diary.lines[:common]:
                    why = f"its participant {diary.identity} is not the {diary.identity} of {directory}"
                    raise BadFile(source, why)
            if here is None or len(diary.lines) > len(here.lines):
                known[diary.identity] = coming[diary.identity] = Diary(joined, diary.lines)
    return list(coming.values())


def take_diaries(journal: Journal, coming: Sequence[Diary], sources: Iterable[Path]) -> None:
    """Write diaries that come, and settings for people where there are none, into an open directory."""
    if coming:
        make_private(journal.directory)
        write_diaries(journal.store, coming)
        for name in (EXPERIMENT, TEXTS):
            here = journal.directory / PEOPLE_DIRECTORY / name
            found = (path for source in sources if (path := source / PEOPLE_DIRECTORY / name).is_file())
            if not here.exists() and (there := next(found, None)):
                write_private(here, read_input(there))
