"""Who came to the end is counted from the diaries: a box that broke is over, one that was given to others is not."""

import pytest
from builders import small_study
from taking_part import START, take_part

from lockprobe.people.completion import flow_of
from lockprobe.people.diary import Broken, Diary, Released
from lockprobe.people.diary_archive import kept_diaries
from lockprobe.people.withdrawal import put

STUDY = small_study(["participant"], p=[0.0, 0.4], trials=2)


@pytest.fixture
def directory(tmp_path):
    take_part(tmp_path, STUDY, "aaaa01", [(0.4, 1, 1), (0.0, 1, 2)], check=True)
    take_part(tmp_path, STUDY, "bbbb02", [(0.0, 1, 1), (0.4, 1, 2)], left_after=1, check=None)
    return tmp_path


def ends_with(directory, line):
    diary = Diary(directory / "people" / "bbbb02.jsonl")
    diary.write(line)


def counts(directory):
    flow = flow_of(directory)
    return flow.joined, flow.finished, flow.left_open, flow.withdrawn


def test_where_nobody_took_part_there_is_none(tmp_path):
    assert flow_of(tmp_path) is None


def test_boxes_are_counted_by_condition(directory):
    assert counts(directory) == (2, 1, 1, 0)
    boxes = flow_of(directory).boxes
    assert [(one.modality, one.p, one.given, one.left_open) for one in boxes] == [
        ("symbolic?tell=state", 0.0, 2, 0),
        ("symbolic?tell=state", 0.4, 2, 1),
    ]
    assert (flow_of(directory).checks, flow_of(directory).right) == (1, 1)


def test_a_box_that_was_given_to_others_is_left_open(directory):
    ends_with(directory, Released(at=START + 1000))
    assert counts(directory) == (2, 1, 1, 0)


def test_a_box_that_broke_is_over(directory):
    turns = {len(kept.lines) + 2 for kept in kept_diaries(directory) if kept.over == {1}}
    ends_with(directory, Broken(at=START + 1000, turn=turns.pop(), box=2))
    assert counts(directory) == (2, 2, 0, 0)


def test_who_withdrew_is_counted_and_nothing_else(directory, tmp_path_factory):
    put(directory / "people" / "withdrawn.json", {"withdrawn": 3})
    assert counts(directory) == (2, 1, 1, 3)
    alone = tmp_path_factory.mktemp("alone")
    (alone / "people").mkdir()
    put(alone / "people" / "withdrawn.json", {"withdrawn": 1})
    assert counts(alone) == (0, 0, 0, 1)
