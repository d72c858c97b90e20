"""All that is kept of somebody reads back as it was written, and what is none is refused."""

import os

import pytest
from builders import small_study, with_right_checksums
from taking_part import START, take_part

from lockprobe.errors import BadFile
from lockprobe.people.diary_archive import kept_diaries, write_diaries

STUDY = small_study(["participant"], p=[0.0, 0.4], trials=2)
ANN, BOB = "aaaa01", "bbbb02"


@pytest.fixture
def there(tmp_path):
    take_part(tmp_path / "there", STUDY, BOB, [(0.0, 1, 1)], platform={"PID": "x1"}, joined=START + 60)
    take_part(tmp_path / "there", STUDY, ANN, [(0.4, 1, 1), (0.0, 1, 2)], left_after=1)
    return tmp_path / "there"


def test_diaries_are_read_in_the_order_in_which_people_joined(there):
    assert [kept.joined.identity for kept in kept_diaries(there)] == [ANN, BOB]


def test_what_is_written_reads_back(there, tmp_path):
    diaries = kept_diaries(there)
    write_diaries(tmp_path / "new", diaries)
    assert kept_diaries(tmp_path / "new") == diaries


def test_over_is_every_box_of_which_nothing_comes_any_more(there):
    ann, bob = kept_diaries(there)
    assert (ann.over, bob.over) == ({1}, {1})
    path = there / "people" / f"{ANN}.jsonl"
    whole = path.read_bytes()
    turn = len(ann.lines) + 2
    path.write_bytes(whole + b'{"kind":"broken","at":1790000900.0,"turn":%d,"box":2}\n' % turn)
    assert kept_diaries(there)[0].over == {1, 2}
    path.write_bytes(whole + b'{"kind":"released","at":1790000900.0}\n')
    assert kept_diaries(there)[0].over == {1, 2}


@pytest.mark.parametrize("identity", ["../evil", "a/b", "ID", "abc", "a" * 33, "x y z"])
def test_no_name_of_a_file_is_taken_from_a_diary(there, identity):
    path = there / "people" / f"{BOB}.jsonl"
    path.write_bytes(path.read_bytes().replace(BOB.encode(), identity.encode()))
    with_right_checksums(path)
    with pytest.raises(BadFile, match="participant"):
        kept_diaries(there)


def test_a_diary_under_another_name_or_with_two_people_is_refused(there):
    path = there / "people" / f"{BOB}.jsonl"
    moved = path.rename(path.with_name("eeee05.jsonl"))
    with pytest.raises(BadFile, match="another participant"):
        kept_diaries(there)
    moved.rename(path)
    path.write_bytes(path.read_bytes() + path.read_bytes().splitlines(keepends=True)[0])
    with pytest.raises(BadFile, match="joins twice"):
        kept_diaries(there)


@pytest.mark.parametrize("gone", [1, 3])
def test_a_diary_that_lacks_an_act_or_has_one_twice_is_refused(there, gone):
    path = there / "people" / f"{BOB}.jsonl"
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join(lines[:gone] + lines[gone + 1 :]))
    with pytest.raises(BadFile, match="an act is missing"):
        kept_diaries(there)
    path.write_bytes(b"".join([*lines[: gone + 1], lines[gone], *lines[gone + 1 :]]))
    with pytest.raises(BadFile, match="stands there twice"):
        kept_diaries(there)


def test_diaries_are_files_of_their_own(there, tmp_path):
    path = there / "people" / f"{BOB}.jsonl"
    away = path.rename(tmp_path / "away.jsonl")
    path.symlink_to(away)
    with pytest.raises(BadFile, match="a file of its own"):
        kept_diaries(there)
    path.unlink()
    os.mkfifo(path)
    with pytest.raises(BadFile, match="a file of its own"):
        kept_diaries(there)
    path.unlink()
    people = (there / "people").rename(tmp_path / "people")
    (there / "people").symlink_to(people)
    with pytest.raises(BadFile, match="a link"):
        kept_diaries(there)
