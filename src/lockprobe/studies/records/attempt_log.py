"""The log of clients' attempts: each is written to disk before its report leaves, so a killed server loses none.

A finished trial is an ordinary record; its rows stay here.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal

from lockprobe.foundation.storage.database import Database
from lockprobe.studies.records.store import check_row, checksum, read
from lockprobe.studies.running.paused_trial import RecordedAttempt

Kind = Literal["begun", "attempt", "broke"]
"""A client begins or resumes a trial; it attempts a joint; the box broke, so it is played again from its first step."""

_NOTHING = RecordedAttempt("")


class AttemptLog:
    """The log of one study in an open store.

    Attributes:
        attempts: The steps of each trial so far.
        times_begun: How often each was begun or resumed since its first step.

    Raises:
        BadFile: If a row is damaged, or one cannot be written.
    """

    def __init__(self, store: Database) -> None:
        self._store = store
        self.attempts: dict[str, list[RecordedAttempt]] = {}
        self.times_begun = Counter[str]()
        columns = "key, kind, joint, claimed, told, hypothesis"
        for number, crc, *row in store.rows(f"select id, crc, {columns} from attempt order by id", nulls=True):  # noqa: S608
            check_row(store, f"attempt {number}, {row[0]}", crc, *row)
            self._follow(row[0], row[1], RecordedAttempt(*row[2:]))

    @classmethod
    def read(cls, directory: Path) -> Mapping[str, Sequence[RecordedAttempt]]:
        """The attempts in a study directory by key of their trial, since its first step."""
        with read(directory) as store:
            return cls(store).attempts

    def write(self, key: str, kind: Kind, step: RecordedAttempt = _NOTHING) -> None:
        """Write what became of a trial."""
        row = key, kind, *step
        with self._store.transaction(sync=True) as writing:
            writing.execute("insert into attempt values (null, ?, ?, ?, ?, ?, ?, ?)", (*row, checksum(*row)))
        self._follow(key, kind, step)

    def _follow(self, key: str, kind: str, step: RecordedAttempt) -> None:
        if kind == "broke":
            self.attempts.pop(key, None)
            del self.times_begun[key]
        elif kind == "begun":
            self.times_begun[key] += 1
        else:
            self.attempts.setdefault(key, []).append(step)
