"""Counts of how far people have come: a box that broke is over, a released one is not."""

import pytest
from builders import small_study
from taking_part import START, take_part

from lockprobe.people.diary import Broken, DiaryWriter, Did, Released, read_diaries
from lockprobe.people.journey import Journey
from lockprobe.people.progress import flow_of
from lockprobe.people.responses import Answers
from lockprobe.people.withdrawal import withdraw, withdrawn
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.store import written

TWO_EACH = small_study(["participant"], p=[0.0, 0.4], trials=2)


@pytest.fixture
def directory(tmp_path):
    take_part(tmp_path, TWO_EACH, "aaaa01", [(0.4, 1, 1), (0.0, 1, 2)], check=True)
    take_part(tmp_path, TWO_EACH, "bbbb02", [(0.0, 1, 1), (0.4, 1, 2)], left_after=1, check=None)
    return tmp_path


def ends_with(directory, line):
    with written(directory) as store:
        DiaryWriter(store, "bbbb02").write(line)


def flow_in(directory):
    return flow_of(TWO_EACH, read_diaries(directory), withdrawn(directory))


def counts(directory):
    flow = flow_in(directory)
    assert flow.consented == flow.withdrawn + flow.screened + flow.left_open + flow.finished
    return flow.consented, flow.finished, flow.left_open, flow.withdrawn


def test_where_nobody_took_part_there_is_none(tmp_path):
    assert flow_in(tmp_path) is None


def test_boxes_are_counted_by_condition(directory):
    assert counts(directory) == (2, 1, 1, 0)
    boxes = flow_in(directory).boxes
    assert [(one.condition, one.given, one.left_open) for one in boxes] == [
        ("truth", 2, 0),
        ("flip?p=0.4", 2, 1),
    ]
    assert (flow_in(directory).checks, flow_in(directory).right) == (1, 1)


def test_a_box_that_was_given_to_others_is_left_open(directory):
    ends_with(directory, Released(at=START + 1000))
    assert counts(directory) == (2, 1, 1, 0)


def test_who_was_screened_out_is_a_person_without_boxes(directory):
    ends_with(directory, Released(at=START + 1000, why="screened"))
    assert counts(directory) == (2, 1, 0, 0)
    assert flow_in(directory).screened == 1
    assert [(one.given, one.left_open) for one in flow_in(directory).boxes] == [(1, 0), (1, 0)]


def test_a_box_that_broke_is_over(directory):
    turns = {len(diary.lines) + 2 for diary in read_diaries(directory) if Journey.of(diary).closed_boxes == {1}}
    ends_with(directory, Broken(at=START + 1000, turn=turns.pop(), box=2))
    assert counts(directory) == (2, 2, 0, 0)


def test_who_withdrew_is_counted_once_and_nothing_else(directory):
    with Journal.open(directory, TWO_EACH) as journal:
        for identity, left in (("cccc03", (2, 1, 1, 0)), ("bbbb02", (2, 1, 0, 1)), ("aaaa01", (2, 0, 0, 2))):
            for _ in range(2):
                withdraw(journal, identity)
                assert counts(directory) == left


def test_rounds_of_questions_on_the_instructions_are_counted_by_person(directory):
    assert (flow_in(directory).questioned, flow_in(directory).second_round) == (0, 0)
    (bob,) = [diary for diary in read_diaries(directory) if diary.identity == "bbbb02"]
    for n, right in enumerate((False, True), 1):
        line = Did(
            at=START + 1000 + n,
            turn=len(bob.lines) + 1 + n,
            scene="comprehension",
            act=Answers(answers=("a",), rt=1.0),
            right=right,
        )
        ends_with(directory, line)
        assert (flow_in(directory).questioned, flow_in(directory).second_round) == (1, n - 1)
