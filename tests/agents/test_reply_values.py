"""Values are read in any spelling that has one reading, and refused where there are two."""

import pytest

from lockprobe.agents.reply_values import values_in
from lockprobe.foundation.errors import ReplyFault
from lockprobe.trial.record import Percept, Situation, Task

TASK = Task(joints=("A", "B", "left slider"), target="B", budget=9)
FIRST = Situation(task=TASK, past=(), percept=Percept())
LATER = Situation(task=TASK, past=(), percept=Percept(joint="A", outcome="blocked"))
ASKED = ["last_action", "hypothesis", "joint"]
USUAL = {"last_action": "moved", "hypothesis": "", "joint": "A"}


def read(**fields):
    return values_in(USUAL | fields, ASKED, ["moved", "did not move"], LATER)


def test_what_is_spelled_as_asked_is_not_respelled():
    assert tuple(read()) == ("A", "moved", "", False)


@pytest.mark.parametrize(
    ("name", "value", "meant"),
    [
        *(("joint", value, "A") for value in ("a", " A ", "'A'", "A.", "joint A", "the A", "the joint A", "A!", ["A"])),
        *(("joint", value, "left slider") for value in ("Left Slider", "left_slider", "LEFT-SLIDER", "leftSlider")),
        *(("joint", f"left{hyphen}slider", "left slider") for hyphen in "\u2010\u2011\u2012\u2013\u2014\u2212"),
        *(("claimed", value, "moved") for value in ("Moved", "moved.", "MOVED", "it moved", "A moved", ["moved"])),
        *(
            ("claimed", value, "blocked")
            for value in ("did not move.", "Did_Not-Move", "didn't move", "didn\u2019t move")
        ),
        *(("claimed", value, "blocked") for value in ("It did not move!", "Joint A did not move", "not moved")),
        ("hypothesis", None, ""),
        ("hypothesis", ["A", "B"], '["A", "B"]'),
    ],
)
def test_another_spelling_is_read_and_noted(name, value, meant):
    found = read(**{"last_action" if name == "claimed" else name: value})
    assert getattr(found, name) == meant
    assert found.respelled


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *(("joint", value) for value in ("A or B", "A, B", "AB", "", "C", ["A", "B"], {"A": "B"}, True, 1.5, "\u0410")),
        *(("last_action", value) for value in ("moved or did not move", "B moved", "none", True, "true", "yes", 1, "")),
        ("hypothesis", "x" * 4001),
    ],
)
def test_what_has_no_reading_or_two_is_refused_by_its_name(name, value):
    with pytest.raises(ReplyFault, match=f"^{name}: "):
        read(**{name: value})


@pytest.mark.parametrize("name", ["joint", "last_action"])
@pytest.mark.parametrize("missing", [{}, {"value": None}])
def test_what_is_needed_and_missing_is_named(name, missing):
    fields = {key: value for key, value in USUAL.items() if key != name} | dict.fromkeys([name] * bool(missing))
    with pytest.raises(ReplyFault, match=f"^{name}: Field required$"):
        values_in(fields, ASKED, ["moved", "did not move"], LATER)


@pytest.mark.parametrize("value", ["None", "none.", None, "", "null"])
def test_in_the_first_step_there_is_one_claim_however_it_is_spelled(value):
    found = values_in({"last_action": value, "joint": "A"}, ["last_action", "joint"], ["none"], FIRST)
    assert (found.claimed, found.respelled) == (None, True)
    with pytest.raises(ReplyFault, match="^last_action: 'moved' is none of none$"):
        values_in({"last_action": "moved", "joint": "A"}, ["last_action", "joint"], ["none"], FIRST)


def test_labels_that_differ_in_what_does_not_matter_are_told_apart_or_refused():
    task = Task(joints=("a", "A", "a-1", "a1"), target="a", budget=9)
    now = Situation(task=task, past=(), percept=Percept())
    for joint in task.joints:
        assert values_in({"joint": joint}, ["joint"], [], now).joint == joint
    for joint in ("A.", "A 1"):
        with pytest.raises(ReplyFault, match="^joint: "):
            values_in({"joint": joint}, ["joint"], [], now)
