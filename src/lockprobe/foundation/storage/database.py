"""One SQLite file that one process writes and any number read meanwhile. A killed process loses nothing it committed.

While it is written it has a log of its own beside it (``-wal``), which is gone when the writer ends: a finished
directory holds one file, which can be copied. On a file system where SQLite's locks fail it is written without them,
since whoever writes has the lock of the directory.

A file from elsewhere runs nothing: its tables, indices and triggers must be those of the schema, word for word.
"""

from __future__ import annotations

import errno
import os
import sqlite3
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager, suppress
from functools import cache
from itertools import count
from pathlib import Path
from typing import Any

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.inputs import LARGEST_INPUT, is_there
from lockprobe.foundation.storage.atomic_file import refuse_links, write_file, writing

_BESIDE = ("-wal", "-shm", "-journal")
"""What SQLite adds to the name of a file for those that it keeps beside it."""

_NAMES_ANOTHER = bytes.fromhex("d9d505f920a163d7")
"""How the file of an unfinished transaction ends that names another file."""

_WAIT = 10.0
"""Seconds that a reader waits for a writer, or a writer for a reader, where only one of them can have the file."""

_SYNC_SECONDS = 0.5
"""A commit is handed to the system at once; the disk is waited for at most this often, and where it is asked for."""

_WITHOUT_LOCKS = "&vfs=unix-none"

_OTHER_WAY = (sqlite3.SQLITE_IOERR, sqlite3.SQLITE_PROTOCOL, sqlite3.SQLITE_CANTOPEN, sqlite3.SQLITE_READONLY)
"""Errors after which a file is opened in another way: where locks fail, and where nothing can be written beside it."""


class Damaged(BadFile):
    """Raised when a file or a row of it is damaged; the rest can be saved. ``found`` says what without the advice."""

    def __init__(self, path: Path, why: str) -> None:
        self.found = f"{path}: {why}"
        super().__init__(
            path, f"{why}; save the rest: `lockprobe import NEW {path.parent}`, where NEW does not exist yet"
        )


class Database:
    """An open file. Use :meth:`writing` or :meth:`reading`."""

    def __init__(self, path: Path, connection: sqlite3.Connection) -> None:
        self.path, self._db = path, connection
        self._synced, self._waits = time.monotonic(), True
        self._absolute = path.absolute()  # also where the working directory changes
        self._opened = _place(path)

    @classmethod
    @contextmanager
    def writing(cls, path: Path, schema: str) -> Iterator[Database]:
        """Open a file to write, which is made if it is missing. The caller keeps other writers away."""
        refuse_links(path)
        there = is_there(path)
        _check_beside(path)
        if not there:
            write_file(path, _new(schema).serialize())
        with writing(path):
            if path.stat().st_nlink > 1:
                raise BadFile(path, "has a second name elsewhere (a hard link), which would be written too: copy it")
        with closing(_opened(path, ("mode=rw", f"mode=rw{_WITHOUT_LOCKS}"), schema, ahead=True)) as connection:
            opened = cls(path, connection)
            try:
                yield opened
                opened.check()
            finally:  # its log is put into the file, which is then alone; where a reader has it open the log is read
                with suppress(sqlite3.Error):
                    connection.execute("pragma synchronous=full")
                    connection.execute("pragma busy_timeout=1000")
                    connection.execute("pragma wal_checkpoint(truncate)")
                    connection.execute("pragma journal_mode=delete")

    @classmethod
    @contextmanager
    def reading(cls, path: Path, schema: str) -> Iterator[Database]:
        """Open a file to read, also while another process writes it."""
        is_there(path)  # what is no file is refused
        last = () if _check_beside(path) else ("mode=ro&immutable=1",)
        undone = ("mode=rw",) if path.with_name(f"{path.name}-journal").exists() else ()
        ways = ("mode=ro", *undone, f"mode=ro{_WITHOUT_LOCKS}", *last)
        with closing(_opened(path, ways, schema)) as connection:
            connection.execute("begin")  # all that is read is of one moment
            yield cls(path, connection)

    def rows(self, sql: str, *values: object, nulls: bool = False) -> Iterator[tuple[Any, ...]]:
        """The rows of a statement that reads, one after the other; values may be missing only with ``nulls``."""
        with _said(self.path):
            for row in self._db.execute(sql, values):
                if None in row and not nulls:
                    raise Damaged(self.path, "damaged (a value is missing)")
                yield row

    def one(self, sql: str, *values: object) -> tuple[Any, ...]:
        """The first row of a statement that always has one."""
        for row in self.rows(sql, *values):
            return row
        raise Damaged(self.path, "damaged (a row is missing)")

    @contextmanager
    def transaction(self, *, sync: bool = False) -> Iterator[sqlite3.Connection]:
        """Write statements whole or not at all; ``sync`` waits until the disk itself has them.

        One within another is a part of that. If somebody else deleted or replaced the file, all that was written is in
        a second file, ``NAME.rescued``.
        """
        with _said(self.path):
            if self._db.in_transaction:
                yield self._db
                return
            now = time.monotonic()
            sync = sync or now - self._synced > _SYNC_SECONDS
            if sync is not self._waits:
                self._db.execute(f"pragma synchronous={'full' if sync else 'normal'}")
                self._waits = sync
            self._db.execute("begin immediate")
            try:
                yield self._db
                self._db.execute("commit")
                self._synced = now if sync else self._synced
            finally:
                if self._db.in_transaction:
                    with suppress(sqlite3.Error):
                        self._db.execute("rollback")
                self.check()

    def check(self) -> None:
        """Check that the file still has its name."""
        if (there := _place(self._absolute)) == self._opened:
            return
        if not self._absolute.parent.is_dir():
            raise BadFile(self.path, "its directory was deleted or moved while it was being written, so this ends here")
        done = "replaced" if there else "deleted"
        names = (self._absolute.with_name(f"{self.path.name}.rescued{number or ''}") for number in count())
        rescued = next(one for one in names if not one.exists())
        said = f"{done} by somebody else while it was being written (a cloud client?), so this ends here; all that was"
        try:
            self._db.execute("vacuum into ?", (str(rescued),))
        except sqlite3.Error as error:
            raise BadFile(self.path, f"{said} written is lost with it ({error})") from error
        raise BadFile(self.path, f"{said} written is in {rescued.name}: put it in its place, and start again")

    def erase(self) -> None:
        """Leave no byte of what was deleted: it is written anew, and its log is emptied."""
        with _said(self.path):
            self._db.execute("vacuum")
            self._db.execute("pragma busy_timeout=1000")  # a server waits here
            (busy, *_) = self._db.execute("pragma wal_checkpoint(truncate)").fetchone()
            self._db.execute(f"pragma busy_timeout={_WAIT * 1000:.0f}")
        if busy:
            raise BadFile(self.path, "is being read by another program, so its log still holds what was deleted")


def rescued_files(path: Path) -> list[Path]:
    """The files next to one that took what was written after it had lost its name."""
    return sorted(one for one in path.parent.glob(f"{path.name}.rescued*") if not one.name.endswith(_BESIDE))


def _check_beside(path: Path) -> bool:
    """Whether something is in what SQLite keeps beside a file."""
    there = False
    for one in (path.with_name(path.name + name) for name in _BESIDE):
        if one.is_symlink():
            raise BadFile(one, "is a link, which is not followed: remove it")
        with suppress(FileNotFoundError):  # it is gone when its writer ends
            if not (is_there(one) and one.stat().st_size):
                continue
            there = True
            if one.name.endswith("-journal") and one.read_bytes().endswith(_NAMES_ANOTHER):
                raise BadFile(one, "names another file, as Lockprobe never writes it: remove it")
            if one.name.endswith("-wal"):
                logged = b""
                with suppress(FileNotFoundError), path.open("rb") as file:
                    logged = file.read(20)[18:]
                if logged != b"\x02\x02":  # as a file says that is written to a log first, until its writer ends
                    why = f"is not the log of this {path.name}, which was put there later: move one of them away"
                    raise BadFile(one, why)
    return there


def _place(path: Path) -> tuple[int, int] | None:
    with suppress(OSError):
        there = path.stat()
        return there.st_dev, there.st_ino
    return None


def _opened(path: Path, ways: Sequence[str], schema: str, *, ahead: bool = False) -> sqlite3.Connection:
    """A connection to a file with the tables of a schema, by the first way that works on this file system.

    A file with other tables is left as it is. ``ahead`` writes to a log beside the file where that works, so that
    readers and the writer do not wait.
    """
    with _said(path), ExitStack() as failed:
        for way in ways:
            failed.close()
            try:
                # one thread at a time uses it, not always the one that opened it
                connection = sqlite3.connect(
                    f"{path.absolute().as_uri()}?{way}",
                    uri=True,
                    isolation_level=None,
                    timeout=_WAIT,
                    check_same_thread=False,
                )
                failed.callback(connection.close)
                connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, LARGEST_INPUT)
                connection.execute("pragma trusted_schema=off")
                connection.execute("pragma secure_delete=on")
                if _tables(connection) != _tables(_new(schema)):
                    raise BadFile(path, "its tables are not those of this release's studies")
                if ahead:
                    with suppress(sqlite3.OperationalError):  # somebody reads it now, or there is no shared memory
                        connection.execute("pragma journal_mode=wal")
                    _tables(connection)  # whether that works here
            except sqlite3.Error as error:
                if way == ways[-1] or _code(error) not in _OTHER_WAY:
                    raise
            else:
                failed.pop_all()
                return connection
    raise AssertionError("no way was given")


def _tables(connection: sqlite3.Connection) -> list[tuple[object, ...]]:
    return connection.execute("select type, name, sql from sqlite_master where sql > '' order by name").fetchall()


@cache
def _new(schema: str) -> sqlite3.Connection:
    """An empty file in memory."""
    connection = sqlite3.connect(":memory:", check_same_thread=False)
    connection.executescript(schema)
    return connection


@contextmanager
def _said(path: Path) -> Iterator[None]:
    """Turn SQLite's errors into mistakes that name the file."""
    try:
        yield
    except (UnicodeDecodeError, sqlite3.Error) as error:
        code = _code(error)
        if isinstance(error, UnicodeDecodeError) or str(error).startswith("Could not decode"):  # and the whole text
            raise Damaged(path, "damaged (a text is not UTF-8)") from None
        if code in (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB):
            raise Damaged(path, f"damaged ({error})") from error
        if code == sqlite3.SQLITE_BUSY:
            raise BadFile(path, f"another program holds it ({error})") from error
        done = "read" if code == sqlite3.SQLITE_CANTOPEN else "written"
        why = os.strerror(errno.ENOSPC) if code == sqlite3.SQLITE_FULL else str(error)
        raise BadFile(path, f"cannot be {done} ({why})") from error


def _code(error: Exception) -> int:
    """What went wrong; SQLite adds details in higher bits."""
    return getattr(error, "sqlite_errorcode", 0) & 0xFF
