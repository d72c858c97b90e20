"""The log of clients' attempts: each is written to disk before its report leaves, so a killed server loses none.

It has a row for every time a trial is begun or taken up again, one for every attempt, and one where a box broke. A
finished trial is an ordinary record; its rows stay here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, ValidationError

from lockprobe.foundation.storage.database import Damaged, Database
from lockprobe.studies.records.store import check_row, checksum, read
from lockprobe.studies.running.paused_trial import RecordedAttempt
from lockprobe.trial.record import Outcome


class AttemptEntry(BaseModel):
    """That a client began or resumed a trial, one attempt with the report that followed, or that the box broke."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    kind: Literal["begun", "attempt", "broke"]
    joint: str = ""
    claimed: Outcome | None = None
    told: str = ""
    hypothesis: str = ""


def attempt_entry(store: Database, number: int, key: str, entry: str, crc: int) -> AttemptEntry:
    """A row of the attempts as an entry."""
    check_row(store, f"attempt {number}, {key}", crc, key, entry)
    try:
        return AttemptEntry.model_validate_json(entry)
    except ValidationError as error:
        raise Damaged(store.path, f"attempt {number}, {key}: {error.errors()[0]['msg']}") from None


class AttemptLog:
    """The log of one study in an open store.

    Attributes:
        entries: What is written of each trial since its first step.

    Raises:
        BadFile: If an entry is damaged, or one cannot be written.
    """

    def __init__(self, store: Database) -> None:
        self._store = store
        self.entries: dict[str, list[AttemptEntry]] = {}
        for row in store.rows("select id, key, entry, crc from attempt order by id"):
            self._follow(row[1], attempt_entry(store, *row))

    @classmethod
    def read(cls, directory: Path) -> Mapping[str, Sequence[RecordedAttempt]]:
        """The attempts in a study directory by key of their trial, since its first step."""
        with read(directory) as store:
            log = cls(store)
        return {key: found for key in log.entries if (found := log.attempts(key))}

    def attempts(self, key: str) -> tuple[RecordedAttempt, ...]:
        """The steps of a trial so far."""
        own = (one for one in self.entries.get(key, ()) if one.kind == "attempt")
        return tuple(RecordedAttempt(one.joint, one.claimed, one.told, one.hypothesis) for one in own)

    def times_begun(self, key: str) -> int:
        """How often a trial was begun or resumed since its first step."""
        return sum(one.kind == "begun" for one in self.entries.get(key, ()))

    def under_way(self, key: str) -> bool:
        """Whether a trial was begun."""
        return self.times_begun(key) > 0

    def begin(self, key: str) -> None:
        """Write that a client begins or resumes a trial."""
        self._write(key, AttemptEntry(kind="begun"))

    def attempt(self, key: str, step: RecordedAttempt) -> None:
        """Write one attempt."""
        self._write(key, AttemptEntry(kind="attempt", **step._asdict()))

    def broke(self, key: str) -> None:
        """Write that the box broke: the trial is played again from its first step."""
        self._write(key, AttemptEntry(kind="broke"))

    def replace(self, key: str, entries: Sequence[AttemptEntry]) -> None:
        """Write the entries of a trial that was finished elsewhere, in place of those that it has here."""
        if (here := self.entries.get(key, [])) != [*entries]:
            for one in [*([AttemptEntry(kind="broke")] if here else []), *entries]:
                self._write(key, one)

    def _write(self, key: str, entry: AttemptEntry) -> None:
        with self._store.transaction(sync=True) as writing:
            said = entry.model_dump_json(exclude_defaults=True)
            writing.execute("insert into attempt (key, entry, crc) values (?, ?, ?)", (key, said, checksum(key, said)))
        self._follow(key, entry)

    def _follow(self, key: str, entry: AttemptEntry) -> None:
        if entry.kind == "broke":
            self.entries.pop(key, None)
        else:
            self.entries.setdefault(key, []).append(entry)
