"""The experimenter sees how far people have come, and nothing that they wrote or were sent with."""

from dataclasses import asdict

import pytest
from seated import people_study, short

from lockprobe.people.diary import Did, Joined, Released, Slot
from lockprobe.people.journey import Journey
from lockprobe.people.progress import progress_of
from lockprobe.people.responses import Answer, Attempt, Next
from lockprobe.people.texts import read_words
from lockprobe.record import STATES

STUDY = people_study(trials=3)
CHECK = {"after": 1, "question": "Blue?", "options": ["blue", "red"], "right": "blue"}
EXPERIMENT = short(checks=[CHECK], questions=[{"name": "how", "question": "How?"}])


def slot(p, trial):
    return Slot(p=p, modality=STATES, repetition=1, trial=trial)


def person(identity, slots, *lines):
    joined = Joined(identity=identity, token="t", at=5.0, platform={"PID": "secret"}, slots=slots, words="en 0")
    pages = [Did(at=6.0, turn=n + 1, scene="page", act=Next(), item=str(n)) for n in (1, 2)]
    return Journey.of([joined, *pages, *lines], EXPERIMENT, read_words("en"))


def box(number, ended):
    return Did(at=10.0 + number, turn=9, scene="box", act=Attempt(joint="A", rt=1.0), box=number, step=1, ended=ended)


def check(right):
    return Did(at=20.0, turn=9, scene="check", act=Answer(answer="x", rt=1.0), item="1", right=right)


@pytest.fixture
def progress():
    ann = person("aaaa", (slot(0.0, 1), slot(0.4, 2)), box(1, "solved"), check(True), box(2, "budget"))
    answered = Did(at=30.0, turn=9, scene="ask", act=Answer(answer="secret", rt=1.0), item="how")
    over = Did(at=25.0, turn=9, scene="over", act=Next(), box=1)
    bob = person("bbbb", (slot(0.4, 1),), box(1, "error"), over, check(False), answered)
    eve = person("eeee", (slot(0.0, 2), slot(0.4, 3)), box(1, "solved"), Released(at=50.0))
    finished = {slot(0.0, 1), slot(0.4, 2), slot(0.0, 2), slot(0.0, 3)}  # the last one was played elsewhere
    return progress_of(STUDY, [ann, bob, eve], finished, 4)


def test_by_condition_every_trial_is_counted_once(progress):
    assert [(one.p, one.slots, one.finished, one.under_way, one.free) for one in progress.conditions] == [
        (0.0, 3, 3, 0, 0), (0.4, 3, 1, 0, 2),
    ]  # fmt: skip
    (begun,) = progress_of(people_study(p=(0.0,)), [person("aaaa", (slot(0.0, 1),))], set(), 0).conditions
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
