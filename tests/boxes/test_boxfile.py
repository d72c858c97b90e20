"""Box files are data from strangers."""

from dataclasses import replace

import pytest
from boxes.conftest import any_box
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from lockprobe.boxes.box import Joint
from lockprobe.boxes.boxfile import read_box, toml_of
from lockprobe.boxes.families import box
from lockprobe.boxes.solve import fault_of
from lockprobe.foundation.errors import BadFile, UserMistake
from lockprobe.foundation.inputs import LARGEST_TOML

GOOD = """
name = "latch"
target = "door"
initial = "00"
[[joints]]
name = "door"
kind = "revolute"
place = [0.2, 0.5]
[[joints]]
name = "pin"
kind = "prismatic"
place = [0.8, 0.5]
[interlock]
door = [{ pin = 1 }]
"""


def written(tmp_path, text):
    path = tmp_path / "box.toml"
    path.write_text(text, "utf-8")
    return path


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("[{ pin = 1 }]", "[{ bolt = 1 }]", "interlock of door: got 'bolt'"),
        ("[{ pin = 1 }]", "[{ pin = 2 }]", "interlock.door.0.pin"),
        ("[{ pin = 1 }]", "[{ pin = 1 }]\npin = [{ door = 1 }]", "unsolvable"),
        ('target = "door"', 'target = "lid"', "target: got 'lid', expected one of door, pin"),
        ('name = "latch"', 'name = "../latch"', "name"),
        (
            'kind = "prismatic"',
            'kind = "magnetic"',
            "joints.1.kind (pin): got 'magnetic', expected 'prismatic' or 'revolute'",
        ),
        (
            'name = "latch"',
            'name = "latch"\nrun = "rm"',
            "run: no such key; keys are name, joints, interlock, initial, target",
        ),
        ("place = [0.2, 0.5]", "", "place: got none for door, expected one for every joint or for none"),
        ('name = "latch"', "name = ", "not TOML"),
        ("place = [0.8, 0.5]", "place = [nan, 0.5]", "joints.1.place"),
        ("[{ pin = 1 }]", "[{ door = 1 }]", "interlock of door: got 'door', expected positions of other joints"),
        ("[{ pin = 1 }]", "[{ pin = 1 }, { pin = 0 }]\npin = [{ door = 1 }]", "contradictory: {pin = 1} of target do"),
        ("[{ pin = 1 }]", "[{ pin = 1, pin = 0 }]", "not TOML"),
        ("[{ pin = 1 }]", "[]", "interlock.door"),
        ("[{ pin = 1 }]", "[{ 'a\\nb' = 1 }]", "expected a name: a letter"),
        ("door = [{", "lid = [{", "interlock: got 'lid', expected one of door, pin"),
        ('name = "pin"', 'name = "door"', "joints: got ['door', 'door'], expected every name once"),
        ('initial = "00"', 'initial = "000"', "initial: got '000', expected one position for each of 2 joints"),
        ('initial = "00"', 'initial = "0x"', "initial: got '0x', expected a 0 or 1 for each joint"),
        (
            'kind = "prismatic"',
            'kind = "prismatic"\nforce = 9',
            "joints.1.force (pin): no such key; keys are name, kind, place",
        ),
    ],
)
def test_what_is_wrong_is_named(tmp_path, old, new, reason):
    assert old in GOOD
    path = written(tmp_path, GOOD.replace(old, new))
    with pytest.raises(BadFile) as mistake:
        read_box(path)
    assert str(mistake.value).startswith(f"{path}: ")
    assert reason in str(mistake.value)
    assert "\n" not in str(mistake.value)


def test_a_large_file_is_refused_unread(tmp_path):
    with pytest.raises(BadFile, match="larger than"):
        read_box(written(tmp_path, GOOD + "#" * LARGEST_TOML))


@settings(max_examples=25)
@given(any_box(), st.lists(st.tuples(st.floats(0, 1), st.floats(0, 1)), min_size=4, max_size=4))
def test_a_box_that_can_be_played_is_read_back_as_it_was_written(tmp_path_factory, drawn, places):
    joints = (replace(joint, place=place) for joint, place in zip(drawn.joints, places, strict=True))
    drawn = replace(drawn, joints=tuple(joints))
    assume(fault_of(drawn) is None)
    path = tmp_path_factory.getbasetemp() / "round.toml"
    path.write_text(toml_of(drawn), "utf-8")
    assert read_box(path) == drawn
    assert toml_of(read_box(path)) == toml_of(drawn)


@pytest.mark.parametrize(
    "change",
    [
        {"name": 'x"\nrun = 1'},
        {"name": "../x"},
        {"joints": (Joint(name='a"', kind="revolute"), Joint(name="b", kind="revolute")), "target": 'a"'},
        {"joints": (Joint(name="a", kind="revolute", place=(2, 0)), Joint(name="b", kind="revolute")), "target": "a"},
    ],
)
def test_names_and_places_that_no_file_may_have_are_not_written(change):
    with pytest.raises(UserMistake):
        toml_of(replace(box("chain-2"), **({"interlock": {}} | change)))
