"""Inside the directory of a study no link is followed for writing; above it and elsewhere links are the user's own."""

import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.storage.atomic_file import make_directory, remove_file, write_file, write_private
from lockprobe.foundation.storage.database import Database

WRITERS = {
    "file": lambda path: write_file(path, "new"),
    "private": lambda path: write_private(path, "new"),
    "directory": make_directory,
    "file in a directory": lambda path: write_file(path / "x", "new"),
    "deleted file in a directory": lambda path: remove_file(path / "there"),
}


@pytest.fixture
def study(tmp_path):
    (tmp_path / "study").mkdir()
    (tmp_path / "study" / "study.json").write_text("{}")
    (tmp_path / "away").mkdir()
    (tmp_path / "away" / "there").write_text("mine")
    (tmp_path / "away" / "study.json").write_text("{}")  # somebody's own study is no way in either
    (tmp_path / "victim").write_text("mine")
    return tmp_path / "study"


def snapshot(directory: Path) -> dict[str, bytes | None]:
    return {str(path): path.read_bytes() if path.is_file() else None for path in sorted(directory.rglob("*"))}


@pytest.mark.parametrize("writer", WRITERS)
@pytest.mark.parametrize("leads", ["../victim", "../away", "../missing", "/dev/null", "there.txt"])
def test_a_link_inside_a_study_is_named_and_not_followed(study, monkeypatch, writer, leads):
    (study / "there.txt").write_text("mine")
    (study / "link").symlink_to(leads)
    before = snapshot(study.parent)
    for path in (
        study / "link",
        Path("link"),
        study / "link" / "deeper",
        study.parent / "away" / ".." / "study" / "link",
    ):
        monkeypatch.chdir(study)
        with pytest.raises(BadFile, match=r"study/link: is a link inside the directory of a study .*, which is not"):
            WRITERS[writer](path)
    assert snapshot(study.parent) == before


def test_what_a_kill_left_of_a_transaction_is_undone_for_a_reader_too_and_deletes_no_file_that_it_names(tmp_path):
    schema = "create table line (text text not null) strict;"
    with Database.writing(tmp_path / "d.db", schema) as store, store.transaction() as writing:
        writing.execute("insert into line values ('kept')")
    (tmp_path / "killed").mkdir()
    with closing(sqlite3.connect(tmp_path / "d.db", isolation_level=None)) as db:
        db.execute("pragma cache_size=1")
        db.execute("begin")
        db.executemany("insert into line values (?)", [("x" * 3000,)] * 99)
        for name in ("d.db", "d.db-journal"):
            shutil.copy(tmp_path / name, tmp_path / "killed" / name)
    path, journal = tmp_path / "killed" / "d.db", tmp_path / "killed" / "d.db-journal"
    left, victim = journal.read_bytes(), tmp_path / "victim"
    victim.write_text("mine")
    named = str(victim).encode()
    size, checksum = len(named).to_bytes(4, "big"), sum(named).to_bytes(4, "big")
    journal.write_bytes(left + (0).to_bytes(4, "big") + named + size + checksum + bytes.fromhex("d9d505f920a163d7"))
    for opening in (Database.reading, Database.writing):
        with pytest.raises(BadFile, match="d.db-journal: names another file"), opening(path, schema):
            pass
    assert victim.read_text() == "mine"
    journal.write_bytes(left)
    with Database.reading(path, schema) as store:
        assert list(store.rows("select text from line")) == [("kept",)]
