"""Finished trials on disk, one line each, appended; written anew only where a person has theirs deleted.

A study directory holds ``study.json`` (the settings), ``trials.jsonl`` (the records), ``timings.jsonl`` (clock
readings, which are no part of a record) and, where a provider was asked, ``asked.jsonl`` and ``calls.jsonl`` (every
call before it is made, and what came of it); where people take part, ``people`` holds what they did. A line that a
crash tore is cut off before the next one is written, and its trial is owed again.
Only one process writes at a time.
"""

from __future__ import annotations

import fcntl
import json
import os
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO, Annotated

from pydantic import Field, TypeAdapter, ValidationError

from lockprobe.errors import BadFile, BadValue, DirectoryBusy, SettingsChanged
from lockprobe.inputs import check_regular, parse_json, read_input
from lockprobe.jsonline import trial_from_json, trial_to_json
from lockprobe.record import Trial
from lockprobe.studies.calls import ASKED, CALLS, Calls
from lockprobe.studies.lines import append_line, cut_torn_tail, sync_directory, whole_lines
from lockprobe.studies.placing import place
from lockprobe.studies.striking import rewritten, without
from lockprobe.studies.study import LATER, Study, beside_people

__all__ = [
    "Journal",
    "LeftOut",
    "Timing",
    "left_out",
    "load",
    "read_journal",
    "read_settings",
    "read_timings",
    "write_settings",
]

_SYNC_SECONDS = 0.5
"""A line is handed to the system at once; the disk is waited for at most this often."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Timing:
    """How long one trial took. Kept apart from the record, which is the same whenever it is made.

    Attributes:
        key: The trial.
        seconds: Wall time from its first look at the box to its end.
        steps: Steps played in that time.
    """

    key: str
    seconds: Annotated[float, Field(ge=0, allow_inf_nan=False)]
    steps: Annotated[int, Field(ge=0, le=2**53)]


_reading: TypeAdapter[Timing] = TypeAdapter(Timing)


@dataclass(frozen=True, slots=True, kw_only=True)
class LeftOut:
    """What a journal holds beside its trials.

    Attributes:
        unfinished_lines: Lines that a crash tore, 0 or 1; their trial is owed again.
        replaced: Records of trials that were played again after an error.
        repeated: Records of trials that had been finished already; the last one counts.
    """

    unfinished_lines: int
    replaced: int
    repeated: int


def load(directory: Path | str) -> list[Trial]:
    """The trials of a study directory, in the order in which they were finished.

    Where a trial was played again after an error, the last record counts.

    Raises:
        BadFile: If there is no journal or a line within it is damaged.
    """
    return read_journal(directory)[0]


def left_out(directory: Path | str) -> LeftOut:
    """How much of a journal :func:`load` leaves out."""
    return read_journal(directory)[1]


def read_journal(directory: Path | str) -> tuple[list[Trial], LeftOut]:
    """Both :func:`load` and :func:`left_out`, read once."""
    path = Path(directory) / "trials.jsonl"
    check_regular(path)
    if not path.is_file():
        raise BadFile(directory, "no trials.jsonl here; is it the directory of a study?")
    trials: dict[str, Trial] = {}
    replaced = repeated = 0
    for number, line in whole_lines(path):
        try:
            trial = trial_from_json(line)
        except BadValue as error:
            raise BadFile(path, f"line {number}: {error}") from error
        before = trials.pop(trial.key, None)
        replaced += before is not None and before.owed_again
        asked = trial.error is not None and trial.error.again  # the same record, owed anew
        repeated += before is not None and not before.owed_again and not asked
        trials[trial.key] = trial
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - 1))
        torn = int(file.read(1) not in (b"", b"\n"))
    return list(trials.values()), LeftOut(unfinished_lines=torn, replaced=replaced, repeated=repeated)


def read_settings(directory: Path | str) -> dict[str, object]:
    """The settings of the study in a directory."""
    path = Path(directory) / "study.json"
    if not path.exists():
        raise BadFile(directory, "no study.json here; is it the directory of a study?")
    settings = parse_json(read_input(path), path)
    if not isinstance(settings, dict) or not _are_of_a_study(settings):
        raise BadFile(path, "not the settings of a study")
    return settings


def _are_of_a_study(settings: Mapping[str, object]) -> bool:
    match settings:
        case {"agents": list(), "p": list(), "repetitions": int(), "trials": int()}:
            return True
        case _:
            return False


def read_timings(directory: Path | str) -> list[Timing]:
    """How long the trials took, the last reading of each; trials whose reading was lost or damaged are missing."""
    path = Path(directory) / "timings.jsonl"
    if not path.is_file():
        return []
    found = {}
    for _, line in whole_lines(path):
        with suppress(ValidationError):
            reading = _reading.validate_json(line)
            found[reading.key] = reading
    return list(found.values())


class Journal:
    """The open journal of one study. Use :meth:`open`."""

    def __init__(
        self, directory: Path, records: IO[bytes], timings: IO[bytes], done: dict[str, Trial], calls: Calls
    ) -> None:
        self.directory = directory
        self.trials = done
        self.calls = calls
        for key in done:
            if not self.owes(key):
                calls.forget(key)
        self._records = records
        self._timings = timings
        self._synced = time.monotonic()

    @classmethod
    @contextmanager
    def open(cls, directory: Path | str, study: Study) -> Iterator[Journal]:
        """Open a directory for writing, new or to resume.

        Raises:
            SettingsChanged: If a study with other settings lives there.
            DirectoryBusy: If another process is writing there.
            BadFile: If it holds something that cannot be read.
        """
        directory = Path(directory)
        for name in ("trials.jsonl", "timings.jsonl"):
            check_regular(directory / name)
        try:
            directory.mkdir(parents=True, exist_ok=True)
            handle = (directory / "trials.jsonl").open("ab", buffering=0)
        except OSError as error:
            raise BadFile(directory, f"cannot be written ({error.strerror})") from error
        with handle as records, (directory / "timings.jsonl").open("ab", buffering=0) as timings:
            _lock(records, directory)
            _claim(directory, study)
            cut_torn_tail(records, directory / "trials.jsonl")
            cut_torn_tail(timings, directory / "timings.jsonl")
            with Calls.open(directory) as calls:
                journal = cls(directory, records, timings, {trial.key: trial for trial in load(directory)}, calls)
                try:
                    yield journal
                finally:
                    journal._close()

    def owes(self, key: str) -> bool:
        """Whether a trial has still to be played: not finished, or broken by something outside the agent."""
        trial = self.trials.get(key)
        return trial is None or trial.owed_again

    def append(self, trial: Trial, timing: Timing) -> None:
        """Put a finished trial on disk.

        Raises:
            BadFile: If it cannot be written.
        """
        if (before := self.trials.get(trial.key)) is not None and before.error is not None:
            trial = replace(trial, replays=max(trial.replays, before.replays + before.error.again))
        clock = {"key": timing.key, "seconds": round(timing.seconds, 6), "steps": timing.steps}
        append_line(self._records, self.directory / "trials.jsonl", trial_to_json(trial))
        append_line(self._timings, self.directory / "timings.jsonl", json.dumps(clock).encode())
        self.trials[trial.key] = replace(trial, steps=())  # so that a long study takes no more memory than a short one
        if not trial.owed_again:
            self.calls.forget(trial.key)
        if time.monotonic() - self._synced > _SYNC_SECONDS:
            self._sync()

    def strike(self, agent: str) -> None:
        """Delete every record of one agent, and its clock readings, as a person asks who withdraws.

        Killed in between, it has to be called again.

        Raises:
            BadFile: If it cannot be written.
        """
        keys, timings, records = without(self.directory, agent)
        self._timings = rewritten(self._timings, self.directory / "timings.jsonl", timings)
        self._records = rewritten(self._records, self.directory / "trials.jsonl", records)
        with suppress(OSError):  # they are in their place already
            sync_directory(self.directory)
        for key in keys:
            if key in self.trials and self.trials[key].agent == agent:
                del self.trials[key]

    def _close(self) -> None:
        try:
            self._sync()
        finally:
            self._records.close()
            self._timings.close()

    def _sync(self) -> None:
        try:
            self.calls.sync()  # first: a trial on disk whose calls are lost would have cost nothing
            os.fsync(self._records.fileno())
        except OSError as error:
            raise BadFile(self.directory, f"cannot be written ({error.strerror})") from error
        self._synced = time.monotonic()


def _lock(records: IO[bytes], directory: Path) -> None:
    """Keep every other process from writing, for as long as the file is open."""
    try:
        fcntl.flock(records, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        raise DirectoryBusy(directory) from None
    if os.fstat(records.fileno()).st_ino != (directory / "trials.jsonl").stat().st_ino:  # it was just rewritten
        raise DirectoryBusy(directory)


def write_settings(directory: Path, study: Study) -> None:
    """Put the settings of a study in place, whole or not at all.

    Raises:
        BadFile: If they cannot be written.
    """
    place(directory / "study.json", f"{json.dumps(study.settings(), indent=2)}\n".encode())


def _claim(directory: Path, study: Study) -> None:
    """Write the settings of a study of which nothing was played, or hold them against those that are there."""
    path = directory / "study.json"
    asked = json.loads(json.dumps(study.settings()))
    played = [name for name in ("trials.jsonl", CALLS, ASKED) if _size(directory / name)]
    if not path.exists() and played:
        raise BadFile(directory, f"holds {played[0]} but no study.json: put it back, or give another --out")
    somebody = path.exists() and any((directory / "people").glob("*.jsonl"))  # who has joined plays this study
    if not (played or somebody):
        write_settings(directory, study)
        return
    there, asked = {**LATER, **read_settings(directory)}, {**LATER, **asked}
    agents = beside_people(there["agents"], study.agents)  # type: ignore[arg-type] # a list
    different = {
        name: (there.get(name), asked.get(name))
        for name in sorted({*there, *asked} - ({"agents"} if agents else set()))
        if there.get(name) != asked.get(name)
    }
    if different:
        raise SettingsChanged(directory, different)
    if agents and list(agents) != there["agents"]:
        write_settings(directory, replace(study, agents=agents))


def _size(path: Path) -> int:
    return path.stat().st_size if path.exists() else 0
