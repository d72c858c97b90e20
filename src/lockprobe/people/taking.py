"""Diaries that are given away, and diaries that were written elsewhere and are taken into the directory of a study."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from lockprobe.agents.participant import check_participant, participant_spec
from lockprobe.errors import BadFile, BadValue
from lockprobe.people.diary import PEOPLE_DIRECTORY, Broken, Did, Joined, Released, read_diary
from lockprobe.people.experiment import EXPERIMENT, Experiment, experiment_from
from lockprobe.record import Trial
from lockprobe.studies.settings import read_study
from lockprobe.studies.study import Study

__all__ = ["Arriving", "Kept", "kept_diaries", "kept_experiment", "without_traces", "write_diaries"]


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
        BadFile: If one is damaged, or its file bears another name than the participant.
    """
    return sorted(_kept(directory), key=lambda kept: (kept.joined.at, kept.joined.identity))


def _kept(directory: Path) -> Iterator[Kept]:
    for path in sorted((directory / PEOPLE_DIRECTORY).glob("*.jsonl")):
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
        yield Kept(joined, then)


def kept_experiment(directory: Path) -> Experiment | None:
    """The settings with which people took part in a study; None where none are kept.

    Raises:
        BadFile: If the file is damaged.
    """
    path = directory / PEOPLE_DIRECTORY / EXPERIMENT
    if not path.is_file():
        return None
    try:
        settings = json.loads(path.read_bytes())
    except (ValueError, RecursionError) as error:
        raise BadFile(path, f"not JSON ({error})") from None
    if not isinstance(settings, dict):
        raise BadFile(path, "not the settings of an experiment")
    return experiment_from(settings, path)


def without_traces(kept: Kept, *, platform: bool = False) -> Kept:
    """The same without what proves who somebody is and without the time of day.

    Args:
        kept: A diary.
        platform: Whether what the recruitment platform said stays.

    Returns:
        No token; every moment in seconds since this participant joined, to the millisecond.
    """
    start = kept.joined.at
    joined = kept.joined.model_copy(
        update={"token": "", "at": 0.0, "platform": kept.joined.platform if platform else {}}
    )
    lines = (line.model_copy(update={"at": round(max(0.0, line.at - start), 3)}) for line in kept.lines)
    return Kept(joined, tuple(lines))


def write_diaries(directory: Path, diaries: Iterable[Kept]) -> None:
    """Put diaries into the directory of a study, each whole or not at all.

    Raises:
        BadFile: If one cannot be written.
    """
    people = directory / PEOPLE_DIRECTORY
    for kept in diaries:
        content = "".join(f"{line.model_dump_json()}\n" for line in (kept.joined, *kept.lines)).encode()
        _put(people / f"{kept.joined.identity}.jsonl", content)


def _put(path: Path, content: bytes) -> None:
    draft = path.with_name(f".{path.name}.draft")
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        with draft.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        draft.replace(path)
    except OSError as error:
        raise BadFile(path, f"cannot be written ({error.strerror})") from error


class Arriving:
    """Diaries of other directories on their way into the directory of a study. Nothing is written before :meth:`take`.

    Who was shown as proof that it is the same stays behind: nobody goes on here who began elsewhere.

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
        here = {kept.joined.identity: kept for kept in _kept(directory)}
        for source in sources:
            for kept in _kept(source):
                kept.check_slots(read_study(source), source)
                identity = kept.joined.identity
                there = self._coming.get(identity) or here.get(identity)
                if there is not None and not _goes_on(there, kept) and not _goes_on(kept, there):
                    raise BadFile(source, f"another participant than the {identity} of {directory}")
                if there is None or len(kept.lines) > len(there.lines):
                    self._coming[identity] = kept

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
        write_diaries(
            self._directory,
            (Kept(kept.joined.model_copy(update={"token": ""}), kept.lines) for kept in taken),
        )
        here = self._directory / PEOPLE_DIRECTORY / EXPERIMENT
        files = [source / PEOPLE_DIRECTORY / EXPERIMENT for source in self._sources]
        if taken and not here.exists() and (found := next(filter(Path.is_file, files), None)):
            _put(here, found.read_bytes())
        return len(taken)


def _goes_on(beginning: Kept, kept: Kept) -> bool:
    """Whether one diary is the other, perhaps further on; moments may be told from another start."""
    same = (beginning.joined.slots, beginning.joined.words) == (kept.joined.slots, kept.joined.words)
    lines = zip(beginning.lines, kept.lines, strict=False)
    further = len(beginning.lines) <= len(kept.lines)
    return same and further and all(a.model_copy(update={"at": b.at}) == b for a, b in lines)
