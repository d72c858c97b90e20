"""Counts of how far people have come hold nothing that they wrote; a box that broke is over, a released one is not."""

from dataclasses import asdict

import pytest
from builders import small_study
from seated import people_study, short
from taking_part import START, take_part

from lockprobe.people.diary import Broken, Diary, DiaryFile, Did, Joined, Released, Slot, read_diaries
from lockprobe.people.journey import Journey, stations
from lockprobe.people.progress import flow_of, progress_of
from lockprobe.people.responses import Answer, Answers, Attempt, Next
from lockprobe.people.texts import read_words
from lockprobe.people.withdrawal import put, withdrawn

STUDY = people_study(trials=3)
CHECK = {"after": 1, "question": "Blue?", "options": ["blue", "red"], "right": "blue"}
EXPERIMENT = short(checks=[CHECK], questions=[{"name": "how", "question": "How?"}])


def slot(condition, trial):
    return Slot(condition=condition, repetition=1, trial=trial)


def person(identity, slots, *lines):
    joined = Joined(identity=identity, token="t", at=5.0, platform={"PID": "secret"}, slots=slots, words="en 0")
    pages = [Did(at=6.0, turn=n + 1, scene="page", act=Next(), item=str(n)) for n in (1, 2)]
    way = stations(EXPERIMENT, read_words("en"), len(slots))
    return Journey.of(Diary(joined, (*pages, *lines)), way)


def box(number, ended):
    return Did(at=10.0 + number, turn=9, scene="box", act=Attempt(joint="A", rt=1.0), box=number, step=1, ended=ended)


def check(right):
    return Did(at=20.0, turn=9, scene="check", act=Answer(answer="x", rt=1.0), item="1", right=right)


@pytest.fixture
def progress():
    ann = person("aaaa", (slot("truth", 1), slot("flip?p=0.4", 2)), box(1, "solved"), check(True), box(2, "budget"))
    answered = Did(at=30.0, turn=9, scene="ask", act=Answer(answer="secret", rt=1.0), item="how")
    over = Did(at=25.0, turn=9, scene="over", act=Next(), box=1)
    bob = person("bbbb", (slot("flip?p=0.4", 1),), box(1, "error"), over, check(False), answered)
    eve = person("eeee", (slot("truth", 2), slot("flip?p=0.4", 3)), box(1, "solved"), Released(at=50.0))
    finished = {
        slot("truth", 1),
        slot("flip?p=0.4", 2),
        slot("truth", 2),
        slot("truth", 3),
    }  # the last one was played elsewhere
    return progress_of(STUDY, [ann, bob, eve], finished, 4)


def test_by_condition_every_trial_is_counted_once(progress):
    assert [(one.condition, one.slots, one.finished, one.under_way, one.free) for one in progress.conditions] == [
        ("truth", 3, 3, 0, 0), ("flip?p=0.4", 3, 1, 0, 2),
    ]  # fmt: skip
    (begun,) = progress_of(people_study(p=(0.0,)), [person("aaaa", (slot("truth", 1),))], set(), 0).conditions
    assert (begun.slots, begun.finished, begun.under_way, begun.free) == (4, 0, 1, 3)


def test_by_person_it_says_how_far_they_are(progress):
    assert [(one.identity, one.stage, one.boxes_done, one.boxes, one.broken) for one in progress.participants] == [
        ("aaaa", "under way", 2, 2, 0), ("bbbb", "finished", 1, 1, 1), ("eeee", "late", 1, 2, 0),
    ]  # fmt: skip
    assert [(one.checks_right, one.checks_wrong) for one in progress.participants] == [(1, 0), (0, 1), (0, 0)]
    assert [one.last_act for one in progress.participants] == [12.0, 30.0, 11.0]


def test_in_all(progress):
    assert (progress.joined, progress.finished, progress.withdrawn, progress.late) == (3, 1, 4, 1)
    assert (progress.checks_right, progress.checks_wrong) == (1, 1)


def test_it_says_nothing_that_somebody_wrote_or_was_sent_with(progress):
    assert "secret" not in str(asdict(progress))


TWO_EACH = small_study(["participant"], p=[0.0, 0.4], trials=2)


@pytest.fixture
def directory(tmp_path):
    take_part(tmp_path, TWO_EACH, "aaaa01", [(0.4, 1, 1), (0.0, 1, 2)], check=True)
    take_part(tmp_path, TWO_EACH, "bbbb02", [(0.0, 1, 1), (0.4, 1, 2)], left_after=1, check=None)
    return tmp_path


def ends_with(directory, line):
    diary = DiaryFile(directory / "people" / "bbbb02.jsonl")
    diary.write(line)


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


def test_who_withdrew_is_counted_and_nothing_else(directory, tmp_path_factory):
    put(directory / "people" / "withdrawn.json", {"withdrawn": 3})
    assert counts(directory) == (5, 1, 1, 3)
    alone = tmp_path_factory.mktemp("alone")
    (alone / "people").mkdir()
    put(alone / "people" / "withdrawn.json", {"withdrawn": 1})
    assert counts(alone) == (1, 0, 0, 1)


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
