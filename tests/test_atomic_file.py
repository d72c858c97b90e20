"""A file that is written is there whole, or what was there before is; what is no regular file stays what it is."""

import os
import socket
import stat
from pathlib import Path

import pytest

from lockprobe.atomic_file import atomic_directory, atomic_file, write_file, write_files
from lockprobe.errors import BadFile


def names(directory):
    return sorted(path.name for path in directory.iterdir())


def half_written(path, error):
    with atomic_file(path) as draft:
        draft.write_text("half")
        raise error


def test_the_file_is_replaced_and_no_draft_is_left(tmp_path):
    for content in ("one\r\n", b"two"):
        write_file(tmp_path / "x.csv", content)
    assert (tmp_path / "x.csv").read_bytes() == b"two"
    assert names(tmp_path) == ["x.csv"]


def test_an_error_leaves_what_was_there(tmp_path):
    write_file(tmp_path / "x.csv", "before")
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


def test_permissions_stay(tmp_path):
    (tmp_path / "x").touch(mode=0o600)
    write_file(tmp_path / "x", "content")
    assert stat.S_IMODE((tmp_path / "x").stat().st_mode) == 0o600


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everything")
def test_a_file_that_is_read_only_is_left_alone(tmp_path):
    (tmp_path / "x").touch(mode=0o444)
    with pytest.raises(BadFile, match="Permission denied"):
        write_file(tmp_path / "x", "content")


@pytest.mark.parametrize("name", ["no/x.csv", "x" * 300])
def test_a_path_that_cannot_be_is_one_line(tmp_path, name):
    with pytest.raises(BadFile, match="cannot be written"):
        write_file(tmp_path / name, "content")


def test_a_directory_is_there_whole_or_not_at_all(tmp_path):
    with pytest.raises(BadFile, match="is a directory"), atomic_directory(tmp_path / "new") as draft:
        write_files({draft / "a": "a", draft: ""})
    assert names(tmp_path) == []
    (tmp_path / "new").mkdir()
    with atomic_directory(tmp_path / "new") as draft:
        (draft / "a").write_text("a")
        assert names(tmp_path / "new") == []
    assert names(tmp_path / "new") == ["a"]
    with pytest.raises(BadFile, match="cannot be written"), atomic_directory(tmp_path / "new") as draft:
        (draft / "b").write_text("b")
    assert names(tmp_path / "new") == ["a"]
