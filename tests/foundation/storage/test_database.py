"""A file of SQLite: whole or not at all, whoever else reads, writes, kills or sends it."""

import os
import shutil
import sqlite3
from contextlib import closing, suppress

import pytest

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.storage import database as module
from lockprobe.foundation.storage.database import Database

SCHEMA = "create table line (id integer primary key, text text not null) strict;"


@pytest.fixture(params=["locks", "no locks"])
def path(request, tmp_path, monkeypatch):
    """A file, also where SQLite's own locks fail: the writer then has the directory's."""
    if request.param == "no locks":
        plain = sqlite3.connect

        def without(name, **more):
            if "mode=" in name and "unix-none" not in name and "immutable" not in name:
                raise _failed("disk I/O error", sqlite3.SQLITE_IOERR)
            return plain(name, **more)

        monkeypatch.setattr(module.sqlite3, "connect", without)
    return tmp_path / "d.db"


def _failed(said, code):
    error = sqlite3.OperationalError(said)
    error.sqlite_errorcode = code
    return error


def put(store, text, **how):
    with store.transaction(**how) as writing:
        writing.execute("insert into line (text) values (?)", (text,))


def texts(path):
    with Database.reading(path, SCHEMA) as store:
        return [text for (text,) in store.rows("select text from line order by id")]


def test_what_is_committed_is_read_while_it_is_written_and_afterwards_from_one_file(path):
    with Database.writing(path, SCHEMA) as store:
        put(store, "one")
        assert texts(path) == ["one"]
        with suppress(ZeroDivisionError), store.transaction() as writing:
            writing.execute("insert into line (text) values ('never')")
            raise ZeroDivisionError
        put(store, "two", sync=True)
        assert texts(path) == ["one", "two"]
    assert [one.name for one in path.parent.iterdir()] == ["d.db"]
    with Database.writing(path, SCHEMA) as store:
        put(store, "three")
    assert texts(path) == ["one", "two", "three"]


def changed_meanwhile(path, change):
    with Database.writing(path, SCHEMA) as store:
        put(store, "one")
        path.unlink()
        if change == "replaced":
            path.write_bytes(b"another")
        put(store, "two")


@pytest.mark.parametrize("change", ["deleted", "replaced"])
def test_who_deletes_or_replaces_it_ends_the_writing_and_all_is_beside_it(path, change):
    for number in ("", "1"):
        with pytest.raises(BadFile, match=f"{change} by somebody else .* is in d.db.rescued{number}: "):
            changed_meanwhile(path, change)
        path.unlink(missing_ok=True)
        assert texts(path.with_name(f"d.db.rescued{number}"))[0] == "one"
        for beside in ("-wal", "-shm"):
            path.with_name(f"d.db{beside}").unlink(missing_ok=True)


def _link(path):
    path.with_name("elsewhere").write_bytes(b"")
    path.symlink_to(path.with_name("elsewhere"))


def _log_that_is_a_link(path):
    path.with_name("elsewhere").write_bytes(b"")
    path.with_name(f"{path.name}-wal").symlink_to(path.with_name("elsewhere"))


def _log_of_another(path):
    with Database.writing(path, SCHEMA) as store:
        put(store, "one")
        log = path.with_name("d.db-wal").read_bytes()
    path.with_name("d.db-wal").write_bytes(log)


def _log_alone(path):
    _log_of_another(path)
    path.unlink()


def _hard_link(path):
    with Database.writing(path, SCHEMA):
        pass
    path.with_name("elsewhere").hardlink_to(path)


def _trigger(path):
    with Database.writing(path, SCHEMA), closing(sqlite3.connect(path)) as db:
        db.execute("create trigger bad after insert on line begin select load_extension('x'); end")


def _view(path):
    with closing(sqlite3.connect(path)) as db:
        db.execute("create view line as select 1 as id, readfile('/etc/passwd') as text")


@pytest.mark.parametrize(
    ("there", "reads", "said"),
    [
        (lambda path: path.write_bytes(b"rubbish " * 999), True, "damaged .file is not a database"),
        (lambda path: path.write_bytes(b""), True, "its tables are not those"),
        (os.mkdir, True, "not a regular file"),
        (os.mkfifo, True, "not a regular file"),
        (_trigger, True, "its tables are not those"),
        (_view, True, "its tables are not those"),
        (_log_that_is_a_link, True, "is a link"),
        (_log_of_another, True, "is not the log of this d.db"),
        (_log_alone, False, "is not the log of this d.db"),
        (_link, False, "is a link inside the directory of a study"),
        (_hard_link, False, "has a second name elsewhere"),
    ],
)
def test_what_somebody_put_there_is_refused_in_one_line(tmp_path, there, reads, said):
    (tmp_path / "study.json").touch()
    path = tmp_path / "d.db"
    if there is _log_that_is_a_link:
        with Database.writing(path, SCHEMA):
            pass
    there(path)
    for opening in (Database.writing, Database.reading)[: 1 + reads]:
        with pytest.raises(BadFile, match=said) as refused, opening(path, SCHEMA):
            pass
        assert "\n" not in str(refused.value)


def test_a_damaged_page_is_said_to_be_damaged_and_how_to_save_the_rest(tmp_path):
    path = tmp_path / "d.db"
    with Database.writing(path, SCHEMA) as store, store.transaction() as writing:
        writing.executemany("insert into line (text) values (?)", [("x" * 500,)] * 99)
    content = bytearray(path.read_bytes())
    content[4096:12288] = b"\xff" * 8192
    path.write_bytes(content)
    with pytest.raises(BadFile, match=r"d.db: damaged .*`lockprobe import NEW "):
        texts(path)


def test_what_is_erased_leaves_no_byte_even_where_a_log_was_left(tmp_path):
    path = tmp_path / "d.db"
    with Database.writing(path, SCHEMA) as store:
        put(store, "secret-one " * 999)
        put(store, "kept")
        with store.transaction() as writing:
            writing.execute("delete from line where text like 'secret%'")
        store.erase()
        assert all(b"secret" not in one.read_bytes() for one in tmp_path.iterdir())
    assert texts(path) == ["kept"]


def test_a_finished_file_is_read_where_nothing_can_be_written(path, monkeypatch):
    with Database.writing(path, SCHEMA) as store:
        put(store, "one")
    plain = sqlite3.connect

    def read_only(name, **more):  # what a directory without the right to write does, also to root
        if "mode=" in name and "immutable" not in name:
            raise _failed("unable to open database file", sqlite3.SQLITE_CANTOPEN)
        return plain(name, **more)

    monkeypatch.setattr(module.sqlite3, "connect", read_only)
    assert texts(path) == ["one"]
    path.with_name("d.db-wal").write_bytes(b"commits")
    content = path.read_bytes()
    path.write_bytes(content[:18] + b"\2\2" + content[20:])  # as a kill leaves it
    with pytest.raises(BadFile, match="d.db: cannot be read .unable to open"):
        texts(path)


def test_what_a_kill_left_of_a_transaction_is_undone_for_a_reader_too_and_deletes_no_file_that_it_names(tmp_path):
    with Database.writing(tmp_path / "d.db", SCHEMA) as store:
        put(store, "kept")
    (tmp_path / "killed").mkdir()
    with closing(sqlite3.connect(tmp_path / "d.db", isolation_level=None)) as db:
        db.execute("pragma cache_size=1")
        db.execute("begin")
        db.executemany("insert into line (text) values (?)", [("x" * 3000,)] * 99)
        for name in ("d.db", "d.db-journal"):
            shutil.copy(tmp_path / name, tmp_path / "killed" / name)
    path, journal = tmp_path / "killed" / "d.db", tmp_path / "killed" / "d.db-journal"
    left, victim = journal.read_bytes(), tmp_path / "victim"
    victim.write_text("mine")
    named = str(victim).encode()
    size, checksum = len(named).to_bytes(4, "big"), sum(named).to_bytes(4, "big")
    journal.write_bytes(left + (0).to_bytes(4, "big") + named + size + checksum + bytes.fromhex("d9d505f920a163d7"))
    for opening in (Database.reading, Database.writing):
        with pytest.raises(BadFile, match="d.db-journal: names another file"), opening(path, SCHEMA):
            pass
    assert victim.read_text() == "mine"
    journal.write_bytes(left)
    assert texts(path) == ["kept"]
