"""A finished trial as a row of the store: its record, and beside it what is asked for without reading that."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.inputs import LARGEST_INPUT
from lockprobe.foundation.storage.database import Damaged, Database
from lockprobe.studies.records.store import read
from lockprobe.trial.record import Trial
from lockprobe.trial.trial_json import TrialReader, likeness, trial_to_json


@dataclass(frozen=True, slots=True, kw_only=True)
class Timing:
    """The duration of one trial, stored beside the record, because records are reproducible and times are not.

    Attributes:
        key: Key of the trial.
        seconds: Wall time from its first observation to its end.
        steps: Steps played in that time.
        cpu: Model of the processor; empty if not known.
    """

    key: str
    seconds: float
    steps: int
    cpu: str = ""


class OnRecord(NamedTuple):
    """What is known of a stored trial without reading its record; all but its length as a trial has it.

    Attributes:
        length: Steps played.
    """

    key: str
    spec: str
    group: str
    player: str
    condition: str
    repetition: int
    trial: int
    ending: str
    owed_again: bool
    length: int

    @property
    def agent(self) -> str:
        """The spec of who played it; of a person ``participant:ID``."""
        return self.player or self.spec

    @property
    def solved(self) -> bool:
        """Whether the target moved."""
        return self.ending == "solved"


class TrialRow(NamedTuple):
    """A trial as it is stored; its fields are the columns of that name."""

    key: str
    agent: str
    player: str
    condition: str
    repetition: int
    trial: int
    fork: str | None
    ending: str
    owed: bool
    steps: int
    seconds: float
    cpu: str
    identity: str
    alike: bytes | None
    record: bytes

    @property
    def timing(self) -> Timing:
        """How long it took."""
        return Timing(key=self.key, seconds=self.seconds, steps=self.steps, cpu=self.cpu)

    def known(self, group: str) -> OnRecord:
        """What is known of it from now on; ``group`` is what keys call its agent."""
        place = self.condition, self.repetition, self.trial
        return OnRecord(self.key, self.agent, group, self.player, *place, self.ending, self.owed, self.steps)


_QUICKLY = 3
"""The level of compression: a tenth larger than by default, in two thirds of the time."""


def row_of(trial: Trial, timing: Timing, identity: str) -> TrialRow:
    """A trial as it is stored. ``identity`` says what was played (:meth:`Study.record_identity`)."""
    record = trial_to_json(trial)
    return TrialRow(
        trial.key,
        trial.spec,
        trial.player,
        trial.condition,
        trial.repetition,
        trial.trial,
        None if trial.fork is None else trial.fork.arm,
        trial.ending,
        trial.owed_again,
        len(trial.steps),
        round(timing.seconds, 6),
        timing.cpu,
        identity,
        likeness(trial),
        zlib.compress(record, _QUICKLY),
    )


COLUMNS = ", ".join(TrialRow._fields)

INSERT = f"insert into trial ({COLUMNS}) values ({', '.join('?' * len(TrialRow._fields))})"  # noqa: S608 - our own


def unpacked(store: Database, key: str, record: bytes) -> bytes:
    """A stored record as JSON."""
    if not isinstance(record, bytes):  # of a file that somebody made
        raise Damaged(store.path, f"{key}: its record is damaged (it is a text)")
    opened, why = zlib.decompressobj(), "it does not end"
    try:
        found = opened.decompress(record, LARGEST_INPUT)
    except zlib.error as error:
        why = str(error)
    if not opened.eof:
        raise Damaged(store.path, f"{key}: its record is damaged ({why})")
    return found


def trial_in(store: Database, reader: TrialReader, key: str, record: bytes) -> Trial:
    """The trial of a stored record."""
    try:
        trial = reader.read(unpacked(store, key, record))
    except BadValue as error:
        raise Damaged(store.path, f"{key}: its record is damaged ({error})") from error
    if trial.key != key:
        raise Damaged(store.path, f"{key}: its record is damaged (it is of {trial.key})")
    return trial


def trials_in(store: Database, where: str) -> Iterator[Trial]:
    """The trials of the rows for which a condition holds, in the order in which they were written."""
    reader = TrialReader()
    for key, record in store.rows(f"select key, record from trial where {where} order by id"):  # noqa: S608 - our own
        yield trial_in(store, reader, key, record)


def replaced_records(directory: Path | str) -> list[Trial]:
    """The records of trials that were owed again, in the order in which they were written."""
    with read(directory) as store:
        return [*trials_in(store, "not current")]


def contradictions(store: Database) -> Iterator[str]:
    """Where rows say something else than their records, or a finished trial has a second record."""
    reader, last = TrialReader(), dict[str, tuple[bool, bool]]()
    for current, *columns in store.rows(f"select current, {COLUMNS} from trial order by id", nulls=True):  # noqa: S608
        row = TrialRow(*columns)
        trial = trial_in(store, reader, row.key, row.record)
        made = row_of(trial, row.timing, row.identity)._replace(record=row.record)
        if different := [name for name in TrialRow._fields if getattr(made, name) != getattr(row, name)]:
            yield f"{row.key}: its {', '.join(different)} are not those of its record"
        over, _ = last.get(row.key, (False, False))
        if over and not (trial.error is not None and trial.error.again):
            yield f"{row.key}: a second record of a finished trial"
        last[row.key] = not trial.owed_again, bool(current)
    yield from (f"{key}: its last record does not count" for key, (_, current) in last.items() if not current)
