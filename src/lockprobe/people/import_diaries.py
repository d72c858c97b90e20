"""Diaries that were written elsewhere are taken into the directory of a study."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from lockprobe.errors import BadFile
from lockprobe.inputs import read_input
from lockprobe.people.diary import PEOPLE_DIRECTORY
from lockprobe.people.diary_archive import Kept, kept_diaries, write_diaries
from lockprobe.people.experiment import EXPERIMENT
from lockprobe.people.texts import TEXTS
from lockprobe.record import Trial
from lockprobe.storage.atomic_file import write_private
from lockprobe.studies.settings import read_study

__all__ = ["Arriving"]


class Arriving:
    """Diaries of other directories on their way into the directory of a study. Nothing is written before :meth:`take`.

    What a browser shows as proof of who somebody is stays behind: nobody goes on here who began elsewhere. Of
    somebody who began here only what came later elsewhere is taken, told by the clock of here.

    Args:
        directory: Of the study.
        sources: Directories with diaries, each with the trials that were finished there.

    Raises:
        BadFile: If a diary is damaged, or two participants have the same ID.
    """

    def __init__(self, directory: Path, sources: Mapping[Path, Iterable[Trial]]) -> None:
        self._directory = directory
        self._sources = tuple(sources)
        self._played_there = {trial.agent for trials in sources.values() for trial in trials}
        self._coming: dict[str, Kept] = {}
        self._here = {kept.joined.identity: kept for kept in kept_diaries(directory)}
        for source in sources:
            for kept in kept_diaries(source):
                kept.check_slots(read_study(source), source)
                identity = kept.joined.identity
                there = self._coming.get(identity) or self._here.get(identity)
                if there is not None and not _goes_on(there, kept) and not _goes_on(kept, there):
                    raise BadFile(source, f"another participant than the {identity} of {directory}")
                if there is None:
                    self._coming[identity] = _nobodys(kept)
                elif len(kept.lines) > len(there.lines):
                    self._coming[identity] = _further(there, kept)

    def take(self, trials: Mapping[str, Trial]) -> int:
        """Write down the diaries that the directory does not have, or has only the beginning of.

        The diary of somebody whose every trial was played by somebody else here is left where it is.

        Args:
            trials: The trials that the directory has now, by key; nobody else may be writing there.

        Returns:
            How many were written.

        Raises:
            BadFile: If one cannot be written.
        """
        players = {trial.agent for trial in trials.values()}
        elsewhere = self._played_there - players
        taken = [kept for kept in self._coming.values() if kept.spec not in elsewhere]
        write_diaries(self._directory, taken)
        for name in (EXPERIMENT, TEXTS) if taken else ():
            here = self._directory / PEOPLE_DIRECTORY / name
            files = [source / PEOPLE_DIRECTORY / name for source in self._sources]
            if not here.exists() and (found := next(filter(Path.is_file, files), None)):
                write_private(here, read_input(found))
        return len(taken)

    def lost(self, trials: Mapping[str, Trial]) -> int:
        """How many boxes that people here have still before them, or have begun, were played by those who came.

        Args:
            trials: The trials that the directory has now, by key.
        """
        study, lost = read_study(self._directory), 0
        for kept in (self._coming.get(identity, kept) for identity, kept in self._here.items()):
            for box, slot in enumerate(kept.joined.slots, 1):
                trial = trials.get(
                    study.plan(kept.spec, study.condition(slot.p, slot.modality), slot.repetition, slot.trial).key
                )
                if trial is None or trial.owed_again or box in kept.over:
                    continue
                lost += trial.agent in self._played_there - {kept.spec}
        return lost


def _nobodys(kept: Kept) -> Kept:
    """The same, with which nobody can go on."""
    return Kept(kept.joined.model_copy(update={"token": ""}), kept.lines)


def _further(beginning: Kept, kept: Kept) -> Kept:
    """A diary with what came after it in another state of the same, told by the clock of the first."""
    start, elsewhere = beginning.joined.at, kept.joined.at
    came = (line.model_copy(update={"at": max(0.0, start + line.at - elsewhere)}) for line in kept.lines)
    return Kept(beginning.joined, (*beginning.lines, *tuple(came)[len(beginning.lines) :]))


def _goes_on(beginning: Kept, kept: Kept) -> bool:
    """Whether one diary is the other, perhaps further on; moments may be told from another start."""
    same = (beginning.joined.slots, beginning.joined.words) == (kept.joined.slots, kept.joined.words)
    lines = zip(beginning.lines, kept.lines, strict=False)
    further = len(beginning.lines) <= len(kept.lines)
    return same and further and all(a.model_copy(update={"at": b.at}) == b for a, b in lines)
