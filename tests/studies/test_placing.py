"""A file is in its place whole, or what was there before is there still."""

import os

import pytest

from lockprobe.errors import BadFile
from lockprobe.studies.placing import place


def test_what_was_put_is_there_and_nothing_else(tmp_path):
    for content in (b"one", b"two"):
        place(tmp_path / "new" / "file.json", content)
        assert (tmp_path / "new" / "file.json").read_bytes() == content
    assert [path.name for path in (tmp_path / "new").iterdir()] == ["file.json"]
    assert (tmp_path / "new").stat().st_mode & 0o077 == 0


def test_what_cannot_be_written_leaves_what_was_there(tmp_path, monkeypatch):
    place(tmp_path / "file", b"before")

    def full(descriptor):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(BadFile, match="No space left"):
        place(tmp_path / "file", b"after")
    assert (tmp_path / "file").read_bytes() == b"before"


def test_file_and_directory_are_on_the_disk_itself_before_it_returns(tmp_path, monkeypatch):
    synced, fsync = [], os.fsync

    def noted(descriptor):
        synced.append(os.fstat(descriptor).st_ino)
        fsync(descriptor)

    monkeypatch.setattr("os.fsync", noted)
    place(tmp_path / "file", b"content")
    assert synced == [(tmp_path / "file").stat().st_ino, tmp_path.stat().st_ino]
