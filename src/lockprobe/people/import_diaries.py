"""Imports diaries that were written elsewhere into the directory of a study."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.inputs import read_input
from lockprobe.foundation.storage.atomic_file import write_private
from lockprobe.people.diary import Diary, make_private, read_diaries, write_diaries
from lockprobe.people.experiment import EXPERIMENT
from lockprobe.people.journey import Journey
from lockprobe.people.texts import TEXTS
from lockprobe.studies.file_names import PEOPLE_DIRECTORY
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.trial_rows import OnRecord


class DiaryImport:
    """An import of diaries into the directory of a study. Nothing is written before :meth:`take`.

    Tokens are not imported, so participants who began elsewhere cannot resume here. Of participants who began here, the
    import takes only later lines.

    Args:
        directory: The directory of the study.
        sources: Directories with diaries, each with the trials that were finished there.

    Raises:
        BadFile: If a diary is damaged, or two participants have the same ID.
    """

    def __init__(self, directory: Path, sources: Mapping[Path, Iterable[OnRecord]]) -> None:
        self._directory = directory
        self._sources = tuple(sources)
        self._played_there = {trial.agent for trials in sources.values() for trial in trials}
        self._coming: dict[str, Diary] = {}
        self._here = {diary.identity: diary for diary in read_diaries(directory)}
        for source in sources:
            for diary in read_diaries(source):
                diary.check_slots(read_study(source), source)
                identity = diary.identity
                there = self._coming.get(identity) or self._here.get(identity)
                if there is not None and not _continues(there, diary) and not _continues(diary, there):
                    raise BadFile(source, f"its participant {identity} is not the {identity} of {directory}")
                if there is None:
                    joined = diary.joined.model_copy(update={"token": ""})  # so that no browser can resume it
                    self._coming[identity] = Diary(joined, diary.lines)
                elif len(diary.lines) > len(there.lines):
                    self._coming[identity] = Diary(there.joined, diary.lines)

    def take(self, journal: Journal) -> int:
        """Write new and longer diaries into the directory, which is open, and return their number.

        Skips participants whose trials were all played by others here.

        Raises:
            BadFile: If one cannot be written.
        """
        players = {trial.agent for trial in journal.trials.values()}
        elsewhere = self._played_there - players
        taken = [diary for diary in self._coming.values() if diary.spec not in elsewhere]
        if taken:
            make_private(self._directory)
        write_diaries(journal.store, taken)
        for name in (EXPERIMENT, TEXTS) if taken else ():
            here = self._directory / PEOPLE_DIRECTORY / name
            files = [source / PEOPLE_DIRECTORY / name for source in self._sources]
            if not here.exists() and (found := next(filter(Path.is_file, files), None)):
                write_private(here, read_input(found))
        return len(taken)

    def lost(self, trials: Mapping[str, OnRecord]) -> int:
        """How many unfinished boxes of people here were played by imported participants."""
        study, lost = read_study(self._directory), 0
        for diary in (self._coming.get(identity, diary) for identity, diary in self._here.items()):
            closed = Journey.of(diary).closed_boxes
            for box, slot in enumerate(diary.joined.slots, 1):
                trial = trials.get(slot.plan(study, diary.identity).key)
                if trial is None or trial.owed_again or box in closed:
                    continue
                lost += trial.agent in self._played_there - {diary.spec}
        return lost


def _continues(beginning: Diary, diary: Diary) -> bool:
    """Whether the second diary equals or continues the first."""
    same = (beginning.joined.slots, beginning.joined.words) == (diary.joined.slots, diary.joined.words)
    return same and diary.lines[: len(beginning.lines)] == beginning.lines
