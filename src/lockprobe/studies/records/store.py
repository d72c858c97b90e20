"""``study.db``: everything that is recorded of a study beside its settings, in one SQLite file.

A finished trial is a row with what numbers are made of (its steps in :mod:`~.shorthand`), beside its record (JSON,
compressed). A trial that was owed again keeps its earlier rows; the one that counts is ``current``. Calls, attempts and
what people did are on disk before anybody relies on them.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from sqlite3 import Connection
from typing import NamedTuple

from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.foundation.inputs import LARGEST_INPUT, is_there
from lockprobe.foundation.storage.atomic_file import atomic_files, make_directory, writing
from lockprobe.foundation.storage.database import Damaged, Database
from lockprobe.studies.records.shorthand import kind_of, shorthand
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.record import Trial
from lockprobe.trial.trial_json import TrialReader, trial_to_json

STORE = "study.db"
"""The name of the file in the directory of a study."""

ALBUM = "pictures"
"""Name of the directory of pictures in the directory of a study."""

SCHEMA = """
create table trial (
  id integer primary key,
  key text not null,
  agent text not null,
  player text not null,
  condition text not null,
  repetition int not null,
  trial int not null,
  fork text,
  ending text not null,
  boundary text not null,
  owed int not null,
  steps int not null,
  seconds real not null,
  identity text not null,
  kind int not null,
  shorthand text not null,
  crc int not null,
  current int not null default 1,
  record blob not null
) strict;
create unique index current_trial on trial (key) where current;
create index counted on trial (identity, agent, ending, boundary, owed, player, repetition, trial, steps, seconds)
  where current;
create index replaced on trial (id) where not current;
create table call (id integer primary key, key text not null, call text not null, crc int not null) strict;
create table attempt (
  id integer primary key,
  key text not null,
  kind text not null,
  joint text not null,
  claimed text,
  told text not null,
  hypothesis text not null,
  crc int not null
) strict;
create table act (
  id integer primary key,
  participant text not null,
  number int not null,
  entry text not null,
  crc int not null,
  unique (participant, number)
) strict;
create table note (name text primary key, value any not null) strict, without rowid;
"""

COLUMNS = (
    *("key", "agent", "player", "condition", "repetition", "trial", "fork", "ending", "boundary", "owed", "steps"),
    *("seconds", "identity", "kind", "shorthand", "crc", "record"),
)
"""What a trial has in its row, in the order of :func:`row_of`."""

INSERT = f"insert into trial ({', '.join(COLUMNS)}) values ({', '.join('?' * len(COLUMNS))})"  # noqa: S608 - our own

_QUICKLY = 3
"""The level of compression: a tenth larger than by default, in two thirds of the time."""


class OnRecord(NamedTuple):
    """What is known of a stored trial without reading its record, as a trial has it."""

    key: str
    spec: str
    group: str
    player: str
    condition: str
    repetition: int
    trial: int
    ending: str
    owed_again: bool

    @classmethod
    def of(cls, trial: Trial) -> OnRecord:
        """The same of a trial."""
        place = trial.condition, trial.repetition, trial.trial
        return cls(trial.key, trial.spec, trial.group, trial.player, *place, trial.ending, trial.owed_again)

    @property
    def agent(self) -> str:
        """The spec of who played it; of a person ``participant:ID``."""
        return self.player or self.spec

    @property
    def solved(self) -> bool:
        """Whether the target moved."""
        return self.ending == "solved"


@contextmanager
def read(directory: Path | str) -> Iterator[Database]:
    """The store of a directory, to be read."""
    path = Path(directory) / STORE
    if not is_there(path):
        raise BadFile(directory, f"no {STORE} here; is it the directory of a study?")
    with Database.reading(path, SCHEMA) as store:
        yield store


def packed(trial: Trial) -> bytes:
    """A trial as the record in its row."""
    return zlib.compress(trial_to_json(trial), _QUICKLY)


def row_of(trial: Trial, seconds: float, identity: str, record: bytes | None = None) -> tuple[object, ...]:
    """A trial as a row.

    Args:
        trial: The trial.
        seconds: How long it took, beside the record, because records are reproducible and times are not.
        identity: What was played (:meth:`Study.record_identity`).
        record: The same trial as :func:`packed` gives it, if that was made already.
    """
    short = kind_of(trial), shorthand(trial)
    return (
        *(trial.key, trial.spec, trial.player, trial.condition, trial.repetition, trial.trial),
        None if trial.fork is None else trial.fork.arm,
        *(trial.ending, "" if trial.error is None else trial.error.boundary, trial.owed_again, len(trial.steps)),
        *(round(seconds, 6), identity, *short),
        checksum(trial.key, trial.repetition, trial.trial, trial.ending, *short),
        packed(trial) if record is None else record,
    )


def unpacked(store: Database, key: str, record: object) -> bytes:
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


def trial_in(store: Database, reader: TrialReader, key: str, record: object) -> Trial:
    """The trial of a stored record."""
    try:
        trial = reader.read(unpacked(store, key, record))
    except BadValue as error:
        raise Damaged(store.path, f"{key}: its record is damaged ({error})") from error
    if trial.key != key:
        raise Damaged(store.path, f"{key}: its record is damaged (it is of {trial.key})")
    return trial


def trials_in(store: Database, where: str, *values: object) -> Iterator[Trial]:
    """The trials of the rows for which a condition holds, in the order in which they were written."""
    reader = TrialReader()
    select = f"select key, record from trial where {where} order by id"  # noqa: S608 - our own conditions
    for key, record in store.rows(select, *values):
        yield trial_in(store, reader, key, record)


def checksum(*columns: object) -> int:
    """The CRC-32 of a row of calls, attempts or acts, or of what a trial is in shorthand, beside the columns.

    A record of a trial has its own inside.
    """
    return zlib.crc32("\n".join(map(str, columns)).encode())


def check_row(store: Database, what: str, crc: object, *columns: object) -> None:
    """Refuse a row whose checksum is not that of its columns."""
    if crc != checksum(*columns):
        raise Damaged(store.path, f"{what}: its checksum is that of something else")


def write_acts(writing: Connection, participant: str, first: int, entries: Iterable[str]) -> None:
    """Add entries to the diary of a participant, within a transaction; ``first`` is the number of the first."""
    rows = ((participant, i, entry, checksum(participant, i, entry)) for i, entry in enumerate(entries, first))
    writing.executemany("insert into act (participant, number, entry, crc) values (?, ?, ?, ?)", rows)


_LOGS = ("trial", "call", "attempt", "act")


def last_rows(directory: Path) -> dict[str, int]:
    """The number of the last trial, call, attempt and act in a directory, by table; 0 without one."""
    if not is_there(directory / STORE):
        return dict.fromkeys(_LOGS, 0)
    with read(directory) as store:
        return {one: int(store.one(f"select coalesce(max(id), 0) from {one}")[0]) for one in _LOGS}  # noqa: S608 - ours


def holds(directory: Path, *tables: str) -> bool:
    """Whether something is in one of these tables of a directory: trials, paid calls or steps fix its settings."""
    last = last_rows(directory)
    return any(last[table] for table in tables)


def keep_picture(album: Path, picture: Picture) -> None:
    """Store a picture in a directory, unless it is there already. Several processes may do so at the same time.

    It is written atomically, before the record that names it, so no record names a missing picture.

    Raises:
        BadFile: If it cannot be written; the trial is then owed, and the run stops.
    """
    path = album / picture.name
    with writing(path):
        if path.is_file() and path.stat().st_size == len(picture.png):
            return
        make_directory(album)  # a study that was deleted does not come back
    with atomic_files(path, tidy=False) as (draft,):
        draft.write_bytes(picture.png)
