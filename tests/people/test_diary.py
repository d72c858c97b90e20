"""What participants did is on disk, reads back as it was written, and can be given away without who did it."""

import os

import pytest
from builders import small_study, with_right_checksums
from taking_part import START, take_part

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.storage.jsonl import with_checksum
from lockprobe.people.diary import (
    Broken,
    DiaryFile,
    Did,
    Joined,
    Released,
    Slot,
    read_diaries,
    read_diary,
    without_identity,
    write_diaries,
)
from lockprobe.people.journey import Journey
from lockprobe.people.responses import Attempt, Next

JOINED = Joined(
    identity="3f9a01bc",
    token="0" * 64,
    at=10.5,
    platform={"PROLIFIC_PID": "abc"},
    slots=(Slot(condition="flip?p=0.4", repetition=1, trial=3),),
    words="en 0",
)
STEP = Did(at=12.0, turn=2, scene="box", act=Attempt(joint="B", rt=412.5), box=1, step=1, told="B moved. At 1: B.")
STUDY = small_study(["participant"], p=[0.0, 0.4], trials=2)
ANN, BOB = "aaaa01", "bbbb02"
RELEASED = with_checksum(b'{"kind":"released","at":1790000900.0}') + b"\n"


@pytest.fixture
def there(tmp_path):
    take_part(tmp_path / "there", STUDY, BOB, [(0.0, 1, 1)], platform={"PID": "x1"}, joined=START + 60)
    take_part(tmp_path / "there", STUDY, ANN, [(0.4, 1, 1), (0.0, 1, 2)], left_after=1)
    return tmp_path / "there"


def test_a_diary_reads_back_as_written(tmp_path):
    diary = DiaryFile(tmp_path / "people" / "3f9a01bc.jsonl")
    lines = [JOINED, Did(at=11.0, turn=2, scene="page", act=Next(), item="1"), STEP]
    lines += [Broken(at=13.0, turn=4, box=2), Released(at=14.0)]
    for line in lines:
        diary.write(line)
    assert read_diary(diary.path) == lines


def test_an_unfinished_line_is_none_and_is_cut_off(tmp_path):
    path = tmp_path / "people" / "3f9a01bc.jsonl"
    diary = DiaryFile(path)
    diary.write(JOINED)
    with path.open("ab") as file:
        file.write(b'{"kind":"did","at":1')
    assert read_diary(path) == [JOINED]
    again = DiaryFile(path)
    again.write(STEP)
    assert read_diary(path) == [JOINED, STEP]


def test_a_damaged_line_is_refused(tmp_path):
    path = tmp_path / "x.jsonl"
    path.write_bytes(b'{"kind":"nothing"}\n')
    with pytest.raises(BadFile, match="line 1"):
        read_diary(path)


def test_only_who_joins_makes_a_diary(tmp_path):
    diary = DiaryFile(tmp_path / "people" / "3f9a01bc.jsonl")
    for line in (STEP, Broken(at=13.0, turn=4, box=2), Released(at=14.0)):
        with pytest.raises(BadFile, match="does not exist"):
            diary.write(line)
    assert not diary.path.exists()
    diary.write(JOINED)
    diary.write(STEP)
    assert read_diary(diary.path) == [JOINED, STEP]


def test_diaries_are_read_in_the_order_in_which_people_joined(there):
    assert [diary.joined.identity for diary in read_diaries(there)] == [ANN, BOB]


def test_what_is_written_reads_back(there, tmp_path):
    diaries = read_diaries(there)
    write_diaries(tmp_path / "new", diaries)
    assert read_diaries(tmp_path / "new") == diaries


def test_over_is_every_box_of_which_nothing_comes_any_more(there):
    ann, bob = read_diaries(there)
    assert (Journey.of(ann).closed_boxes, Journey.of(bob).closed_boxes) == ({1}, {1})
    path = there / "people" / f"{ANN}.jsonl"
    whole = path.read_bytes()
    turn = len(ann.lines) + 2
    path.write_bytes(whole + with_checksum(b'{"kind":"broken","at":1790000900.0,"turn":%d,"box":2}' % turn) + b"\n")
    assert Journey.of(read_diaries(there)[0]).closed_boxes == {1, 2}
    path.write_bytes(whole + RELEASED)
    assert Journey.of(read_diaries(there)[0]).closed_boxes == {1, 2}


@pytest.mark.parametrize("identity", ["../evil", "a/b", "ID", "abc", "a" * 33, "x y z"])
def test_no_name_of_a_file_is_taken_from_a_diary(there, identity):
    path = there / "people" / f"{BOB}.jsonl"
    path.write_bytes(path.read_bytes().replace(BOB.encode(), identity.encode()))
    with_right_checksums(path)
    with pytest.raises(BadFile, match="participant"):
        read_diaries(there)


def test_a_diary_under_another_name_or_with_two_people_is_refused(there):
    path = there / "people" / f"{BOB}.jsonl"
    moved = path.rename(path.with_name("eeee05.jsonl"))
    with pytest.raises(BadFile, match="another participant"):
        read_diaries(there)
    moved.rename(path)
    path.write_bytes(path.read_bytes() + path.read_bytes().splitlines(keepends=True)[0])
    with pytest.raises(BadFile, match="joins twice"):
        read_diaries(there)


@pytest.mark.parametrize("gone", [1, 3])
def test_a_diary_that_lacks_an_act_or_has_one_twice_is_refused(there, gone):
    path = there / "people" / f"{BOB}.jsonl"
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join(lines[:gone] + lines[gone + 1 :]))
    with pytest.raises(BadFile, match="an act is missing"):
        read_diaries(there)
    path.write_bytes(b"".join([*lines[: gone + 1], lines[gone], *lines[gone + 1 :]]))
    with pytest.raises(BadFile, match="missing or duplicated"):
        read_diaries(there)


def test_diaries_are_files_of_their_own(there, tmp_path):
    path = there / "people" / f"{BOB}.jsonl"
    away = path.rename(tmp_path / "away.jsonl")
    path.symlink_to(away)
    with pytest.raises(BadFile, match="a regular file, not a link"):
        read_diaries(there)
    path.unlink()
    os.mkfifo(path)
    with pytest.raises(BadFile, match="a regular file, not a link"):
        read_diaries(there)
    path.unlink()
    people = (there / "people").rename(tmp_path / "people")
    (there / "people").symlink_to(people)
    with pytest.raises(BadFile, match="a link"):
        read_diaries(there)


def test_without_traces_no_token_no_platform_and_no_time_of_day_is_left(there):
    bob = read_diaries(there)[1]
    given = without_identity(bob)
    assert (given.joined.token, given.joined.platform, given.joined.at) == ("", {}, 0.0)
    assert [act.at for act in given.acts] == [1.5 * act.turn for act in given.acts]
    assert [act.act for act in given.acts] == [act.act for act in bob.acts]
    assert without_identity(bob, platform=True).joined.platform == {"PID": "x1"}
    assert without_identity(given) == given


def test_a_place_that_was_given_away_stays_given_away(there, tmp_path):
    path = there / "people" / f"{ANN}.jsonl"
    with path.open("ab") as file:
        file.write(RELEASED)
    ann = read_diaries(there)[0]
    write_diaries(tmp_path / "new", [without_identity(ann)])
    (again,) = read_diaries(tmp_path / "new")
    assert again.lines[-1] == Released(at=900.0 - 0.25)
    assert again.lines[:-1] == again.acts
