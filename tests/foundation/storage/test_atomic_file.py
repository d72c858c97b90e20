"""A file that is written is there whole, or what was there before is; what is no regular file stays what it is."""

import os
import socket
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.storage.atomic_file import (
    Replacement,
    atomic_files,
    remove_file,
    sync_directory,
    write_file,
    write_files,
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


def test_of_several_files_all_are_written_or_none(tmp_path):
    write_file(tmp_path / "a", "before")
    (tmp_path / "b").mkdir()
    with pytest.raises(BadFile, match="b: is a directory, not a regular file"):
        write_files({tmp_path / "a": "after", tmp_path / "b": "after"})
    assert (tmp_path / "a").read_text() == "before"
    assert names(tmp_path) == ["a", "b"]


def test_the_disk_has_file_and_directory_before_it_returns(tmp_path, monkeypatch):
    synced, fsync = [], os.fsync

    def noted(descriptor):
        synced.append(os.fstat(descriptor).st_ino)
        fsync(descriptor)

    monkeypatch.setattr("os.fsync", noted)
    write_file(tmp_path / "x", "content")
    assert synced == [(tmp_path / "x").stat().st_ino, tmp_path.stat().st_ino]
    with pytest.raises(OSError, match="No such file"):
        sync_directory(tmp_path / "missing")


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
    with pytest.raises(BadFile, match=f"is {kind}, not a regular file: choose another name"):
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


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everything")
def test_a_file_that_is_read_only_is_left_alone(tmp_path):
    (tmp_path / "x").touch(mode=0o444)
    with pytest.raises(BadFile, match="Permission denied"):
        write_file(tmp_path / "x", "content")


@pytest.mark.parametrize("name", ["no/x.csv", "x" * 300, "x\0"])
def test_a_path_that_cannot_be_is_one_line(tmp_path, name):
    with pytest.raises(BadFile, match="cannot be written"):
        write_file(tmp_path / name, "content")


def killed(path):
    """What is there of a file that one process writes alone, when that is killed while it writes."""
    code = (
        "import os, sys; from pathlib import Path; from lockprobe.foundation.storage.atomic_file import atomic_files\n"
        "with atomic_files(Path(sys.argv[1]), alone=True) as (draft,): draft.write_text('torn'); os._exit(9)"
    )
    assert subprocess.run([sys.executable, "-c", code, str(path)]).returncode == 9
    return names(path.parent)


def test_a_killed_draft_is_hidden_and_the_next_writer_or_the_end_of_its_file_deletes_it(tmp_path):
    path = tmp_path / "x.jsonl"
    assert killed(path) == [".x.jsonl.draft"]
    assert not list(tmp_path.glob("*.jsonl"))
    write_file(path, "whole", alone=True)
    assert (names(tmp_path), path.read_text()) == (["x.jsonl"], "whole")
    assert killed(path) == [".x.jsonl.draft", "x.jsonl"]
    for _ in range(2):
        remove_file(path)
        assert names(tmp_path) == []
    (tmp_path / ".x.draft").mkdir()
    with pytest.raises(BadFile, match="x: cannot be written"):
        write_file(tmp_path / "x", "content", alone=True)


def test_several_processes_may_write_one_file(tmp_path):
    first, second = (Replacement(tmp_path / "x.csv") for _ in range(2))
    for one in (first, second):
        one.draft.write_text(one.draft.name)
    for one in (first, second):
        one.sync()
        one.rename()
    assert (tmp_path / "x.csv").read_text() == second.draft.name
    assert second.draft.name.endswith(".draft.csv")


def test_a_private_file_makes_a_directory_that_nobody_else_reads(tmp_path):
    path = tmp_path / "new" / "people" / "secret"
    for content in ("one", "two"):
        write_private(path, content, mode=0o600)
        assert path.read_text() == content
    assert (permissions(path), permissions(path.parent)) == (0o600, 0o700)
    assert names(path.parent) == ["secret"]
    (tmp_path / "file").touch()
    with pytest.raises(BadFile, match="cannot be written"):
        write_private(tmp_path / "file" / "x", "content")


def test_what_is_in_its_place_is_written_even_where_the_directory_cannot_be_forced_to_the_disk(tmp_path, monkeypatch):
    fsync = os.fsync

    def files_only(descriptor):
        if stat.S_ISDIR(os.fstat(descriptor).st_mode):
            raise OSError(22, "Invalid argument")
        fsync(descriptor)

    monkeypatch.setattr("os.fsync", files_only)
    write_file(tmp_path / "x", "content")
    assert (tmp_path / "x").read_text() == "content"
