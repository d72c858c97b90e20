"""The journal of a study: an append-only file of finished trials, one line each.

A study directory holds ``study.json`` (the settings), ``trials.jsonl`` (the records), ``timings.jsonl`` (clock
readings, which are no part of a record) and, where a provider was asked, ``asked.jsonl`` and ``calls.jsonl`` (every
call before it is made, and its outcome). With people, the directory ``people`` holds their diaries. A line torn by a
crash is cut off before the next line is written, and its trial is owed again. Only one process writes at a time.

The journal is append-only, except that a participant's withdrawal deletes their records (:meth:`Journal.delete_agent`).
The new file then replaces the old one atomically. The clock readings are replaced first, so after a kill the deletion
can be repeated (idempotent) as long as the records are there. In that case the reading of another participant for the
same trial may be lost.
"""

from __future__ import annotations

import fcntl
import json
import os
import re
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

from pydantic import Field, TypeAdapter, ValidationError

from lockprobe.foundation.errors import DirectoryBusy
from lockprobe.foundation.inputs import is_there
from lockprobe.foundation.storage.atomic_file import Replacement, remove_file, sync_directory, write_file, writing
from lockprobe.foundation.storage.jsonl import LineFile, rescued_files, whole_lines
from lockprobe.studies.costs.call_log import Calls
from lockprobe.studies.file_names import RECORDS, TIMINGS
from lockprobe.studies.records.directory import StudyDirectory, claim
from lockprobe.studies.records.read_records import read_records
from lockprobe.studies.study import Study
from lockprobe.trial.model_call import Count, Seconds
from lockprobe.trial.record import Trial
from lockprobe.trial.trial_json import trial_to_line

_SYNC_SECONDS = 0.5
"""A line is handed to the system at once; the disk is waited for at most this often."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Timing:
    """The duration of one trial, stored apart from the record, because records are reproducible and times are not.

    Attributes:
        key: Key of the trial.
        seconds: Wall time from its first observation to its end.
        steps: Steps played in that time.
        cpu: Model of the processor; empty if not known.
    """

    key: str
    seconds: Seconds
    steps: Count
    cpu: Annotated[str, Field(max_length=200)] = ""


_reading: TypeAdapter[Timing] = TypeAdapter(Timing)

_CLOCK = re.compile(rb'"seconds": ([0-9]+(?:\.[0-9]+)?(?:e-?[0-9]+)?), "steps": ([0-9]+)')
"""What a clock reading says, as it is written."""


def read_timings(directory: Path | str) -> list[Timing]:
    """The durations of the trials, the last reading of each; lost and damaged readings are missing."""
    path = Path(directory) / TIMINGS
    if not is_there(path):
        return []
    found = {}
    for _, line in whole_lines(path):
        with suppress(ValidationError):
            reading = _reading.validate_json(line)
            found[reading.key] = reading
    return list(found.values())


def time_played(directory: Path | str) -> tuple[float, int]:
    """Seconds and steps of all playing, that of trials that were played again too; lost readings are missing."""
    path, seconds, steps = Path(directory) / TIMINGS, 0.0, 0
    for _, line in whole_lines(path) if is_there(path) else ():
        if found := _CLOCK.search(line):
            seconds, steps = seconds + float(found[1]), steps + int(found[2])
    return seconds, steps


class Journal:
    """The open journal of one study. Use :meth:`open`.

    Attributes:
        directory: The directory of the study.
        trials: Finished and broken trials by key; trials played in this run without their steps.
        calls: The log of provider calls.
        identities: Label of a condition -> the identity of its records (:meth:`Study.record_identity`).
        left_out: Its other contents when it was opened.
        used: Whether steps of a trial are on disk; set it to True, and an error removes nothing.
    """

    def __init__(self, directory: Path, study: Study, records: LineFile, timings: LineFile, calls: Calls) -> None:
        trials, self.left_out = read_records(directory)
        self.used = False
        self.directory = directory
        self.trials = {trial.key: trial for trial in trials}
        self.calls = calls
        for key in self.trials:
            if not self.owes(key):
                calls.forget(key)
        self.identities = {one.label: study.record_identity(one) for one in study.conditions}
        self._records = records
        self._timings = timings
        self._synced = time.monotonic()

    @classmethod
    @contextmanager
    def open(cls, directory: Path | str, study: Study) -> Iterator[Journal]:
        """Open a directory for writing, new or to resume. A failed start leaves it unchanged.

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
                    here.used = journal.used or journal._records.used or calls.used
                    journal._close()

    def owes(self, key: str) -> bool:
        """Whether a trial is owed: not finished, or broken by something outside the agent."""
        trial = self.trials.get(key)
        return trial is None or trial.owed_again

    def append(self, trial: Trial, timing: Timing, line: bytes = b"") -> None:
        """Append a finished trial to the file.

        Args:
            trial: The trial.
            timing: How long it took.
            line: Its line (:func:`lockprobe.trial.trial_json.trial_to_line`), if another process has written it.

        Raises:
            BadFile: If it cannot be written, or another process has changed the file; see :class:`LineFile`.
        """
        if (before := self.trials.get(trial.key)) is not None and before.error is not None:
            trial, line = replace(trial, replays=max(trial.replays, before.replays + before.error.again)), b""
        clock = {"key": timing.key, "seconds": round(timing.seconds, 6), "steps": timing.steps}
        clock |= {"cpu": timing.cpu} if timing.cpu else {}
        self._records.append(line or trial_to_line(trial, self.identities[trial.condition]))
        self._timings.append(json.dumps(clock).encode())
        self.trials[trial.key] = replace(trial, steps=())  # so that a long study takes no more memory than a short one
        if not trial.owed_again:
            self.calls.forget(trial.key)
        if time.monotonic() - self._synced > _SYNC_SECONDS:
            self._sync()

    def check(self) -> None:
        """Check that no other process has changed the records or the clock readings.

        Raises:
            BadFile: If they have.
        """
        self._records.check()
        self._timings.check()

    def delete_agent(self, agent: str) -> None:
        """Delete all records and clock readings of one agent, when a participant withdraws.

        Idempotent: if the process is killed meanwhile, call it again.

        Raises:
            BadFile: If it cannot be written.
        """
        keys, timings, records = without(self.directory, agent)
        self._timings = rewritten(self._timings, timings)
        self._records = rewritten(self._records, records)
        for rescued in rescued_files(self.directory / RECORDS):
            _delete_records(rescued, agent)
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
        with writing(self.directory):
            self.calls.sync()  # first: a trial on disk whose calls are lost would have cost nothing
            self._records.sync()
        self._synced = time.monotonic()


def _lock(records: LineFile, directory: Path) -> None:
    """Lock the file against other writers while it is open."""
    try:
        fcntl.flock(records, fcntl.LOCK_EX | fcntl.LOCK_NB)
        now = (directory / RECORDS).stat().st_ino
    except OSError:
        raise DirectoryBusy(directory) from None
    if os.fstat(records.fileno()).st_ino != now:  # it was just rewritten
        raise DirectoryBusy(directory)


def without(directory: Path, agent: str) -> tuple[set[str], Iterator[bytes], Iterator[bytes]]:
    """The contents of a journal without the records of one agent.

    Args:
        directory: The directory of the study.
        agent: Agent spec.

    Returns:
        Keys of the agent's trials; remaining lines of clock readings; remaining lines of records. A trial that somebody
        else has played too has one reading per record, in the same order, and the other's reading stays. If the numbers
        differ, the readings cannot be assigned, and none stays.
    """
    records, timings = directory / RECORDS, directory / TIMINGS
    owners: dict[str, list[str]] = {}
    for line in _lines(records):
        key, owner = _owner(line)
        owners.setdefault(key, []).append(owner)
    return (
        {key for key, played in owners.items() if agent in played},
        _readings(timings, owners, agent),
        (line for line in _lines(records) if _owner(line)[1] != agent),
    )


def _delete_records(path: Path, agent: str) -> None:
    """Delete the records of an agent from a file that is not open; an empty file is deleted.

    Raises:
        BadFile: If it cannot be written.
    """
    stay = [line for line in _lines(path) if _owner(line)[1] != agent]
    if stay:
        write_file(path, b"".join(stay), alone=True)
    else:
        remove_file(path)


def _readings(timings: Path, owners: Mapping[str, Sequence[str]], agent: str) -> Iterator[bytes]:
    """The clock readings of all other agents."""
    readings = Counter(_key(line) for line in _lines(timings))
    met: Counter[str] = Counter()
    for line in _lines(timings):
        key = _key(line)
        played = owners.get(key, ())
        if agent not in played or (readings[key] == len(played) and played[met[key]] != agent):
            yield line
        met[key] += 1


def rewritten(old: LineFile, lines: Iterable[bytes]) -> LineFile:
    """Replace the lines of an open file atomically, close it, and return the new file, open for appending.

    Not :func:`write_file`, because the new file has to be open and locked before it is renamed.

    Raises:
        BadFile: If it cannot be written, or another process has changed it; then the old one stays.
    """
    old.check()
    replacement = Replacement(old.path, alone=True)
    with writing(old.path), ExitStack() as undo:
        undo.callback(replacement.drop)
        replacement.create()
        new = undo.enter_context(closing(LineFile(replacement.draft)))
        fcntl.flock(new, fcntl.LOCK_EX | fcntl.LOCK_NB)
        for line in lines:
            new.append(line.rstrip(b"\n"))
        replacement.sync()
        replacement.rename()
        undo.pop_all()
    new.path = old.path
    old.close()
    return new


def _lines(path: Path) -> Iterator[bytes]:
    return (line for _, line in whole_lines(path))


def _owner(line: bytes) -> tuple[str, str]:
    """The key and the agent of a record."""
    record = json.loads(line)
    return str(record["key"]), str(record["agent"])


def _key(reading: bytes) -> str:
    """The key of a clock reading; empty if the reading is damaged."""
    with suppress(ValueError, TypeError, KeyError, RecursionError):
        return str(json.loads(reading)["key"])
    return ""
