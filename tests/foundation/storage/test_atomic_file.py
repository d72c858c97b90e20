"""A file is there whole, or what was there before is; what is no regular file stays, and no link in a study is followed."""

import errno
import os
import resource
import socket
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.storage.atomic_file import (
    append_whole,
    atomic_files,
    make_directory,
    write_file,
    write_private,
)


def names(directory):
    return sorted(path.name for path in directory.iterdir())


def half_written(path, error):
    with atomic_files(path) as (draft,):
        draft.write_text("half")
        raise error


def test_an_error_leaves_what_was_there(tmp_path):
    for content in (b"first\r\n", "before"):
        write_file(tmp_path / "x.csv", content)
    with pytest.raises(BadFile, match=r"x.csv: cannot be written \(No space left on device\)"):
        half_written(tmp_path / "x.csv", OSError(28, "No space left on device"))
    with pytest.raises(KeyboardInterrupt):
        half_written(tmp_path / "x.csv", KeyboardInterrupt())
    assert (tmp_path / "x.csv").read_text() == "before"
    assert names(tmp_path) == ["x.csv"]


def test_where_nothing_can_be_written_it_is_one_line(tmp_path, monkeypatch):
    def read_only(*_, **__):  # what a file system that is mounted so says of files that are not there, too
        raise OSError(errno.EROFS, "Read-only file system")

    with monkeypatch.context() as mounted:
        mounted.setattr(os, "open", read_only)
        mounted.setattr(os, "unlink", read_only)
        with pytest.raises(BadFile, match=r"x: cannot be written \(Read-only file system"):
            write_file(tmp_path / "x", "content")


def test_of_several_files_all_are_written_or_none(tmp_path):
    write_file(tmp_path / "a", "before")
    (tmp_path / "b").mkdir()
    with pytest.raises(BadFile, match="b: not a regular file"), atomic_files(tmp_path / "a", tmp_path / "b"):
        pass
    assert (tmp_path / "a").read_text() == "before"
    assert names(tmp_path) == ["a", "b"]


def test_a_link_stays_and_its_file_is_replaced(tmp_path):
    (tmp_path / "there").mkdir()
    (tmp_path / "link.csv").symlink_to(tmp_path / "there" / "x.csv")
    for content in ("new", "newer"):  # first the link leads nowhere yet
        write_file(tmp_path / "link.csv", content)
        assert (tmp_path / "there" / "x.csv").read_text() == content
        assert (tmp_path / "link.csv").is_symlink()
    assert names(tmp_path / "there") == ["x.csv"]


@pytest.mark.parametrize("kind", ["a pipe", "a socket", "a directory", "a device"])
@pytest.mark.parametrize("linked", [False, True])
def test_what_is_no_regular_file_is_refused_and_stays(tmp_path, monkeypatch, kind, linked):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "it"
    if kind == "a pipe":
        os.mkfifo(path)
    elif kind == "a socket":
        bound = socket.socket(socket.AF_UNIX)
        bound.bind("it")
        bound.close()
    elif kind == "a directory":
        path.mkdir()
    else:
        path.symlink_to("/dev/null")
    if linked:
        (tmp_path / "link").symlink_to(path)
        path = tmp_path / "link"
    before = stat.S_IFMT(path.stat().st_mode)
    with pytest.raises(BadFile, match="(it|link): not a regular file"):
        write_file(path, "content")
    assert stat.S_IFMT(path.stat().st_mode) == before
    assert stat.S_ISCHR(Path("/dev/null").stat().st_mode)
    assert not [name for name in names(tmp_path) if "draft" in name]


def permissions(path):
    return stat.S_IMODE(path.stat().st_mode)


def test_permissions_stay_and_a_draft_has_them_from_the_first_byte(tmp_path):
    (tmp_path / "x").touch(mode=0o600)
    with atomic_files(tmp_path / "x") as (draft,):
        assert (permissions(draft), draft.read_bytes()) == (0o600, b"")
    assert permissions(tmp_path / "x") == 0o600


@pytest.mark.parametrize("name", ["no/x.csv", "x" * 300, "x\0"])
def test_a_path_that_cannot_be_is_one_line(tmp_path, name):
    with pytest.raises(BadFile, match="cannot be (read|written)"):
        write_file(tmp_path / name, "content")


def test_what_a_killed_process_left_is_hidden_and_the_next_writer_in_the_directory_deletes_it(tmp_path):
    code = (
        "import os, sys; from pathlib import Path; from lockprobe.foundation.storage.atomic_file import atomic_files\n"
        "with atomic_files(Path(sys.argv[1])) as (draft,): draft.write_text('torn'); os._exit(9)"
    )
    assert subprocess.run([sys.executable, "-c", code, str(tmp_path / "x.csv")]).returncode == 9
    (left,) = names(tmp_path)
    assert left.startswith(".")
    assert left.endswith(".draft.csv")
    with atomic_files(tmp_path / "y") as (of_the_living,):
        write_file(tmp_path / "z", "whole")
        assert names(tmp_path) == [of_the_living.name, "z"]
    assert names(tmp_path) == ["y", "z"]


def test_lines_that_cannot_all_be_written_leave_nothing(tmp_path):
    (path := tmp_path / "x").write_bytes(b"a\nb")
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, limits[1]))
    try:
        with pytest.raises(BadFile, match=r"x: cannot be written \(File too large\)"):
            append_whole(path, b"c" * 2000)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert path.read_bytes() == b"a\nb"
    for lines in (b"c\n", b"", b"d"):
        append_whole(path, lines)
    assert path.read_bytes() == b"a\nb\nc\nd"


WRITERS = {
    "file": lambda path: write_file(path, "new"),
    "more of a file": lambda path: append_whole(path, b"new"),
    "private": lambda path: write_private(path, "new"),
    "directory": make_directory,
    "file in a directory": lambda path: write_file(path / "x", "new"),
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
    around = study.parent / "away" / ".." / "study" / "link"
    for path in (study / "link", Path("link"), study / "link" / "deeper", around):
        monkeypatch.chdir(study)
        with pytest.raises(BadFile, match=r"study/link: is a link inside the directory of a study .*, which is not"):
            WRITERS[writer](path)
    assert snapshot(study.parent) == before
