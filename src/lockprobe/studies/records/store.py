"""``study.db``: everything that is recorded of a study beside its settings, in one SQLite file.

A finished trial is a row with what is asked for without its steps, beside its record (JSON, compressed). A trial that
was owed again keeps its earlier rows; the one that counts is ``current``. Calls, attempts and what people did are on
disk before anybody relies on them.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from sqlite3 import Connection

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.inputs import check_regular, is_there
from lockprobe.foundation.storage.database import Damaged, Database

STORE = "study.db"
"""The name of the file in the directory of a study."""

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
  owed int not null,
  steps int not null,
  seconds real not null,
  cpu text not null,
  identity text not null,
  alike blob,
  current int not null default 1,
  record blob not null
) strict;
create unique index current_trial on trial (key) where current;
create index counted on trial (alike, identity, agent, repetition, trial, steps, seconds) where current;
create index replaced on trial (id) where not current;
create table call (id integer primary key, key text not null, asked text, answer text, crc int not null) strict;
create index open_call on call (id) where answer is null;
create table attempt (id integer primary key, key text not null, entry text not null, crc int not null) strict;
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


@contextmanager
def written(directory: Path) -> Iterator[Database]:
    """The store of a directory, to be written; made if it is missing. The caller has locked the directory."""
    with Database.writing(directory / STORE, SCHEMA) as store:
        yield store


@contextmanager
def read(directory: Path | str) -> Iterator[Database]:
    """The store of a directory, to be read."""
    path = Path(directory) / STORE
    check_regular(path)
    if not path.is_file():
        raise BadFile(directory, f"no {STORE} here; is it the directory of a study?")
    with Database.reading(path, SCHEMA) as store:
        yield store


def checksum(*columns: object) -> int:
    """The CRC-32 of a row of calls, attempts or acts, beside its columns; a record of a trial has its own inside."""
    return zlib.crc32("\n".join(map(str, columns)).encode())


def check_row(store: Database, what: str, crc: object, *columns: object) -> None:
    """Refuse a row whose checksum is not that of its columns."""
    if crc != checksum(*columns):
        raise Damaged(store.path, f"{what}: its checksum is that of something else")


def write_acts(writing: Connection, participant: str, first: int, entries: Iterable[str]) -> None:
    """Add entries to the diary of a participant, within a transaction; ``first`` is the number of the first."""
    rows = ((participant, i, entry, checksum(participant, i, entry)) for i, entry in enumerate(entries, first))
    writing.executemany("insert into act (participant, number, entry, crc) values (?, ?, ?, ?)", rows)


def holds_records(directory: Path) -> bool:
    """Whether trials, paid calls or steps are stored in a directory, so that its settings are no longer free."""
    return any(_last_rows_in(directory)[:3])


def has_joined(directory: Path) -> bool:
    """Whether somebody takes part in a directory."""
    return any(_last_rows_in(directory)[3:])


def _last_rows_in(directory: Path) -> tuple[int, ...]:
    if not is_there(directory / STORE):
        return ()
    with read(directory) as store:
        return last_rows(store)


def last_rows(store: Database) -> tuple[int, ...]:
    """The numbers of the last trial, call, attempt and act; 0 without one."""
    tables = ("trial", "call", "attempt", "act")
    return tuple(int(store.one(f"select coalesce(max(id), 0) from {one}")[0]) for one in tables)  # noqa: S608 - ours


def played_in(store: Database) -> tuple[int, float]:
    """The steps and seconds of all playing, that of trials that were played again too."""
    parts = [store.one(f"select total(steps), total(seconds) from trial where {one}") for one in _PARTS]  # noqa: S608
    return int(sum(steps for steps, _ in parts)), sum(seconds for _, seconds in parts)


_PARTS = ("current and alike is null", "current and alike is not null", "not current")
"""Each has an index that holds what is summed, so that no record is read."""
