"""What participants did is on disk, and an unfinished line is none."""

import pytest

from lockprobe.errors import BadFile
from lockprobe.people.diary import Broken, Diary, Did, Joined, Released, Slot, read_diary
from lockprobe.people.responses import Attempt, Next
from lockprobe.storage.jsonl import without_checksum

JOINED = Joined(
    identity="3f9a01bc",
    token="0" * 64,
    at=10.5,
    platform={"PROLIFIC_PID": "abc"},
    slots=(Slot(p=0.4, modality="symbolic", repetition=1, trial=3),),
    words="en 0",
)
STEP = Did(at=12.0, turn=2, scene="box", act=Attempt(joint="B", rt=412.5), box=1, step=1, told="B moved. At 1: B.")


def test_a_diary_reads_back_as_written(tmp_path):
    diary = Diary(tmp_path / "people" / "3f9a01bc.jsonl")
    lines = [JOINED, Did(at=11.0, turn=2, scene="page", act=Next(), item="1"), STEP]
    lines += [Broken(at=13.0, turn=4, box=2), Released(at=14.0)]
    for line in lines:
        diary.write(line)
    assert read_diary(diary.path) == lines


def test_an_unfinished_line_is_none_and_is_cut_off(tmp_path):
    path = tmp_path / "people" / "3f9a01bc.jsonl"
    diary = Diary(path)
    diary.write(JOINED)
    with path.open("ab") as file:
        file.write(b'{"kind":"did","at":1')
    assert read_diary(path) == [JOINED]
    again = Diary(path)
    again.write(STEP)
    assert read_diary(path) == [JOINED, STEP]


def test_a_damaged_line_is_refused(tmp_path):
    path = tmp_path / "x.jsonl"
    path.write_bytes(b'{"kind":"nothing"}\n')
    with pytest.raises(BadFile, match="line 1"):
        read_diary(path)


def test_a_changed_line_is_refused_and_one_of_an_earlier_release_is_read(tmp_path):
    diary = Diary(tmp_path / "people" / "3f9a01bc.jsonl")
    diary.write(JOINED)
    line = diary.path.read_bytes()
    diary.path.write_bytes(without_checksum(line) + b"\n")
    assert read_diary(diary.path) == [JOINED]
    diary.path.write_bytes(line.replace(b'"trial":3', b'"trial":2'))
    with pytest.raises(BadFile, match="line 1: checksum: .* the line was changed"):
        read_diary(diary.path)


def test_only_who_joins_makes_a_diary(tmp_path):
    diary = Diary(tmp_path / "people" / "3f9a01bc.jsonl")
    for line in (STEP, Broken(at=13.0, turn=4, box=2), Released(at=14.0)):
        with pytest.raises(BadFile, match="is not there"):
            diary.write(line)
    assert not diary.path.exists()
    diary.write(JOINED)
    diary.write(STEP)
    assert read_diary(diary.path) == [JOINED, STEP]
