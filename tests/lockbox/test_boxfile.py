"""Box files are data from strangers."""

import pytest

from lockprobe.errors import BadFile
from lockprobe.lockbox.boxfile import MAX_BYTES, box_from_data, read_box
from lockprobe.lockbox.families import box, named_boxes

GOOD = """
name = "latch"
target = "door"
initial = "00"
[[joints]]
name = "door"
kind = "revolute"
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


def test_a_box_is_read(tmp_path):
    box = read_box(written(tmp_path, GOOD))
    assert box.names == ("door", "pin")
    assert not box.may_move((False, False), 0)
    assert box.may_move((False, True), 0)
    assert box.joints[1].place == (0.8, 0.5)


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("[{ pin = 1 }]", "[{ bolt = 1 }]", "interlock of door: got 'bolt'"),
        ("[{ pin = 1 }]", "[{ pin = 2 }]", "interlock.door.0.pin"),
        ("[{ pin = 1 }]", "[{ pin = 1 }]\npin = [{ door = 1 }]", "unsolvable"),
        ('initial = "00"', 'initial = "0"', "initial"),
        ('target = "door"', 'target = "lid"', "target: got 'lid', expected one of door, pin"),
        ('name = "latch"', 'name = "../latch"', "name"),
        ('kind = "prismatic"', 'kind = "magnetic"', "joints.1.kind"),
        ('name = "latch"', 'name = "latch"\nrun = "rm"', "run"),
        ('name = "latch"', "name = ", "not TOML"),
        ("place = [0.8, 0.5]", "place = [nan, 0.5]", "joints.1.place"),
    ],
)
def test_what_is_wrong_is_named(tmp_path, old, new, reason):
    assert old in GOOD
    path = written(tmp_path, GOOD.replace(old, new))
    with pytest.raises(BadFile) as mistake:
        read_box(path)
    assert str(mistake.value).startswith(f"{path}: ")
    assert reason in str(mistake.value)
    assert "\n" not in str(mistake.value).splitlines()[0]


def test_a_large_file_is_refused_unread(tmp_path):
    with pytest.raises(BadFile, match="larger than"):
        read_box(written(tmp_path, GOOD + "#" * MAX_BYTES))


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(BadFile, match="cannot be read"):
        read_box(tmp_path / "none.toml")


def test_deep_nesting_is_refused(tmp_path):
    with pytest.raises(BadFile):
        read_box(written(tmp_path, "a = " + "[" * 20000 + "]" * 20000))


@pytest.mark.parametrize("name", named_boxes())
def test_a_box_written_as_data_is_read_back(tmp_path, name):
    assert box_from_data(box(name).as_data(), tmp_path) == box(name)


@pytest.mark.parametrize("data", [None, [], {"name": "x"}, {**box("chain-2").as_data(), "target": "lid"}])
def test_data_that_is_no_box_is_refused(tmp_path, data):
    with pytest.raises(BadFile, match="study.json"):
        box_from_data(data, tmp_path / "study.json")
