"""Pictures are on disk once, whole, under the names that records give."""

import multiprocessing

import pytest

from lockprobe.foundation.errors import BadFile
from lockprobe.studies.records.picture_store import Album
from lockprobe.trial.pictures.picture import Picture

ONE, TWO = Picture(kind="rgb", png=b"one"), Picture(kind="depth16", png=b"two", shown=False)


def test_every_picture_is_kept_under_its_name(tmp_path):
    album = Album(tmp_path / "pictures")
    for picture in (ONE, TWO, ONE):
        album.keep(picture)
    kept = {path.name: path.read_bytes() for path in (tmp_path / "pictures").iterdir()}
    assert kept == {ONE.name: b"one", TWO.name: b"two"}


def test_a_picture_that_a_crash_tore_is_written_again(tmp_path):
    (tmp_path / ONE.name).write_bytes(b"o")
    Album(tmp_path).keep(ONE)
    assert (tmp_path / ONE.name).read_bytes() == b"one"


def test_an_album_that_cannot_be_written_is_said_in_one_line(tmp_path):
    (tmp_path / "pictures").write_text("in the way")
    with pytest.raises(BadFile, match=r"pictures.*\.png: cannot be written"):
        Album(tmp_path / "pictures").keep(Picture(kind="rgb", png=b"picture"))


def keep_many(directory):
    album = Album(directory)
    for i in range(200):
        album.keep(Picture(kind="rgb", png=bytes([i % 20]) * 5000))


def test_several_processes_may_keep_the_same_pictures(tmp_path):
    context = multiprocessing.get_context("fork")
    processes = [context.Process(target=keep_many, args=(tmp_path,)) for _ in range(3)]
    for process in processes:
        process.start()
    for process in processes:
        process.join()
    assert [process.exitcode for process in processes] == [0, 0, 0]
    kept = sorted(path.read_bytes() for path in tmp_path.iterdir())
    assert kept == sorted(bytes([i]) * 5000 for i in range(20))
