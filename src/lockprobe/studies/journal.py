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
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

from pydantic import Field, TypeAdapter, ValidationError

from lockprobe.errors import BadFile, DirectoryBusy
from lockprobe.record import Trial
from lockprobe.storage.atomic_file import sync_directory
from lockprobe.storage.jsonl import LineFile, rescued_files, whole_lines
from lockprobe.studies.call_log import Calls
from lockprobe.studies.delete_records import rewritten, without, without_agent
from lockprobe.studies.directory import RECORDS, TIMINGS, StudyDirectory, claim
from lockprobe.studies.records import LeftOut, left_out, load, read_records
from lockprobe.studies.study import Study
from lockprobe.trial_json import trial_to_line

__all__ = ["Journal", "LeftOut", "Timing", "left_out", "load", "read_timings"]

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
    """The open journal of one study. Use :meth:`open`.

    Attributes:
        directory: Of the study.
        trials: Finished and broken trials by key, without their steps where they were played just now.
        calls: What was asked of providers.
        left_out: What it holds beside these trials, as it was opened.
    """

    def __init__(self, directory: Path, study: Study, records: LineFile, timings: LineFile, calls: Calls) -> None:
        trials, self.left_out = read_records(directory)
        self.directory = directory
        self.trials = {trial.key: trial for trial in trials}
        self.calls = calls
        for key in self.trials:
            if not self.owes(key):
                calls.forget(key)
        self._identity = study.record_identity
        self._records = records
        self._timings = timings
        self._synced = time.monotonic()

    @classmethod
    @contextmanager
    def open(cls, directory: Path | str, study: Study) -> Iterator[Journal]:
        """Open a directory for writing, new or to resume. Where a start fails it is left as it was.

        Raises:
            SettingsChanged: If a study with other settings lives there.
            DirectoryBusy: If another process is writing there.
            BadFile: If it holds something that cannot be read.
        """
        directory = Path(directory)
        with (
            StudyDirectory(directory) as here,
            closing(LineFile(directory / RECORDS)) as records,
            closing(LineFile(directory / TIMINGS)) as timings,
        ):
            _lock(records, directory)
            claim(directory, study)
            records.cut_torn_tail()
            timings.cut_torn_tail()
            with Calls.open(directory) as calls:
                journal = cls(directory, study, records, timings, calls)
                try:
                    yield journal
                finally:
                    here.used = journal._records.used or calls.used
                    journal._close()

    def owes(self, key: str) -> bool:
        """Whether a trial has still to be played: not finished, or broken by something outside the agent."""
        trial = self.trials.get(key)
        return trial is None or trial.owed_again

    def append(self, trial: Trial, timing: Timing) -> None:
        """Put a finished trial on disk.

        Raises:
            BadFile: If it cannot be written, or somebody else has changed the file; see :class:`LineFile`.
        """
        if (before := self.trials.get(trial.key)) is not None and before.error is not None:
            trial = replace(trial, replays=max(trial.replays, before.replays + before.error.again))
        clock = {"key": timing.key, "seconds": round(timing.seconds, 6), "steps": timing.steps}
        self._records.append(trial_to_line(trial, self._identity))
        self._timings.append(json.dumps(clock).encode())
        self.trials[trial.key] = replace(trial, steps=())  # so that a long study takes no more memory than a short one
        if not trial.owed_again:
            self.calls.forget(trial.key)
        if time.monotonic() - self._synced > _SYNC_SECONDS:
            self._sync()

    def check(self) -> None:
        """Refuse to go on where somebody else has changed the records or the clock readings.

        Raises:
            BadFile: If they have.
        """
        self._records.check()
        self._timings.check()

    def strike(self, agent: str) -> None:
        """Delete every record of one agent, and its clock readings, as a person asks who withdraws.

        Killed in between, it has to be called again.

        Raises:
            BadFile: If it cannot be written.
        """
        keys, timings, records = without(self.directory, agent)
        self._timings = rewritten(self._timings, timings)
        self._records = rewritten(self._records, records)
        for rescued in rescued_files(self.directory / RECORDS):
            without_agent(rescued, agent)
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
            self._records.sync()
        except OSError as error:
            raise BadFile(self.directory, f"cannot be written ({error.strerror})") from error
        self._synced = time.monotonic()


def _lock(records: LineFile, directory: Path) -> None:
    """Keep every other process from writing, for as long as the file is open; earlier releases lock this alone."""
    try:
        fcntl.flock(records, fcntl.LOCK_EX | fcntl.LOCK_NB)
        now = (directory / RECORDS).stat().st_ino
    except OSError:
        raise DirectoryBusy(directory) from None
    if os.fstat(records.fileno()).st_ino != now:  # it was just rewritten
        raise DirectoryBusy(directory)
