"""What is made quickly is what the dataclass itself makes: equal, frozen, with the same arguments."""

import pickle
from dataclasses import FrozenInstanceError, dataclass, field, replace

import pytest

from lockprobe.foundation.quick import quick, quick_replace
from lockprobe.trial.record import Decision, Moment, Percept, Situation, Snapshot, Step, Trial, Turn


@dataclass(frozen=True, slots=True, kw_only=True)
class Report:
    """Has a field of every kind."""

    joint: str
    moved: bool = True
    sensed: dict = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Place:
    """Takes its first field by place."""

    row: int
    column: int = field(default=0, kw_only=True)


def test_it_makes_equal_values():
    make = quick(Report)
    assert make(joint="A") == Report(joint="A")
    made, meant = make(joint="A", moved=False, sensed={"x": 1}), Report(joint="A", moved=False, sensed={"x": 1})
    assert (made, type(made), repr(made)) == (meant, Report, repr(meant))
    assert hash(quick(Place)(1, column=2)) == hash(Place(1, column=2))
    assert pickle.loads(pickle.dumps(made)) == replace(made) == meant


def test_it_replaces_fields():
    before = Report(joint="A", moved=False, sensed={"x": 1})
    for changes in ({}, {"joint": "B"}, {"moved": True, "sensed": {}}):
        assert quick_replace(Report)(before, **changes) == replace(before, **changes)
    assert before == Report(joint="A", moved=False, sensed={"x": 1})
    with pytest.raises(TypeError):
        quick_replace(Report)(before, colour="red")


def test_they_cannot_be_changed_and_share_nothing():
    make = quick(Report)
    one, other = make(joint="A"), make(joint="A")
    assert one.sensed is not other.sensed
    with pytest.raises(FrozenInstanceError):
        one.joint = "B"


@pytest.mark.parametrize("wrong", [{}, {"joint": "A", "colour": "red"}])
def test_it_takes_what_the_class_takes(wrong):
    with pytest.raises(TypeError):
        quick(Report)(**wrong)
    with pytest.raises(TypeError):
        quick(Report)("A")
    with pytest.raises(TypeError):
        quick(Place)(1, 2)


@pytest.mark.parametrize("kind", [Decision, Moment, Percept, Situation, Snapshot, Step, Trial, Turn])
def test_no_class_of_a_record_does_more_when_it_is_made(kind):
    assert not hasattr(kind, "__post_init__")
