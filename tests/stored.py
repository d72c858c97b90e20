"""The store of a study as a test reads and edits it: SQL, and records as objects."""

import json
import sqlite3
import zlib
from collections.abc import Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, closing, contextmanager
from pathlib import Path
from typing import Any

from lockprobe.foundation.storage.database import Database
from lockprobe.studies.costs.call_log import Calls
from lockprobe.studies.records.store import INSERT, SCHEMA, STORE, checksum, read, row_of, write_acts
from lockprobe.trial.trial_json import TrialReader


def written(directory: Path) -> AbstractContextManager[Database]:
    """The store of a directory, to be written; made if it is missing."""
    return Database.writing(directory / STORE, SCHEMA)


def sql(directory: Path, statement: str, *values: object) -> list[Any]:
    """What a statement gives; rows of one column as their values. What it writes is written; it can call checksum."""
    with closing(sqlite3.connect(directory / STORE)) as db, db:
        db.create_function("checksum", -1, checksum)
        rows = db.execute(statement, values).fetchall()
    return [row[0] if len(row) == 1 else row for row in rows]


def timings(directory: Path, column: str = "seconds") -> list[Any]:
    """Of the trials that count, how long each took, or another column of its row: ``key`` or ``steps``."""
    return sql(directory, f"select {column} from trial where current order by id")


def records(directory: Path) -> list[dict[str, Any]]:
    """All records as objects, those that were replaced too, in the order in which they were written."""
    return [json.loads(zlib.decompress(one)) for one in sql(directory, "select record from trial order by id")]


def rewrite(directory: Path, objects: Iterable[dict[str, Any]], identities: Sequence[str]) -> None:
    """Put records in place of all others, each in a row that says what it says; of a trial the last one counts."""
    with written(directory) as store, store.transaction() as writing:
        writing.execute("delete from trial")
        for one, identity in zip(objects, identities, strict=True):
            record = json.dumps(one, ensure_ascii=False, separators=(",", ":")).encode()
            row = row_of(TrialReader().read(record), 1.0, identity, zlib.compress(record))
            writing.execute("update trial set current = 0 where key = ?", row[:1])
            writing.execute(INSERT, row)


def store_lines(directory: Path) -> None:
    """Put the lines of ``trials.jsonl`` and of ``people`` into the store: the form in which frozen studies are kept."""
    path = directory / "trials.jsonl"
    lines = [_of_line(line) for line in path.read_bytes().splitlines()]
    identities = [line.pop("identity") for line in lines]
    rewrite(directory, lines, identities)
    path.unlink()
    for path in sorted((directory / "people").glob("*.jsonl")):
        rewrite_acts(directory, path.stem, map(_of_line, path.read_bytes().splitlines()))
        path.unlink()


def _of_line(line: bytes) -> dict[str, Any]:
    """The object on a line, without its checksum."""
    return {name: value for name, value in json.loads(line).items() if name != "crc"}


def acts(directory: Path, identity: str) -> list[dict[str, Any]]:
    """What is in the diary of a participant, as objects."""
    found = sql(directory, "select entry from act where participant = ? order by number", identity)
    return [json.loads(entry) for entry in found]


def rewrite_acts(directory: Path, identity: str, entries: Iterable[dict[str, Any]]) -> None:
    """Put entries in place of the diary of a participant."""
    with written(directory) as store, store.transaction() as writing:
        writing.execute("delete from act where participant = ?", (identity,))
        write_acts(writing, identity, 1, map(json.dumps, entries))


@contextmanager
def call_log(directory: Path) -> Iterator[Calls]:
    """The open log of calls of a directory."""
    with written(directory) as store:
        yield Calls(store)


def contents(directory: Path) -> dict[str, object]:
    """What is in the files of a directory: of the store its rows, with records as JSON."""
    files = [path for path in directory.rglob("*") if path.is_file() and not path.name.startswith(f"{STORE}-")]
    return {
        str(path.relative_to(directory)): _rows(path) if path.name == STORE else path.read_bytes() for path in files
    }


def _rows(path: Path) -> list[tuple[object, ...]]:
    with read(path.parent) as store:
        tables = [name for (name,) in store.rows("select name from sqlite_master where type = 'table'")]
        rows = [(table, *row) for table in tables for row in store.rows(f"select * from {table}", nulls=True)]
    return [(*row[:-1], zlib.decompress(row[-1])) if row[0] == "trial" else row for row in rows]
