"""What can be asked for, and the one line for what cannot."""

from dataclasses import dataclass

import pytest

from lockprobe.environment.settings import Settings, read_settings
from lockprobe.errors import BadFile, BadValue, UnknownName, UserMistake
from lockprobe.interventions.camera import CameraChannel
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.interventions.words import TextChannel
from lockprobe.lockbox.families import box

FILE = """
name = "two"
target = "door"
initial = "00"
[[joints]]
name = "door"
kind = "revolute"
[[joints]]
name = "bar"
kind = "prismatic"
[interlock]
door = [{ bar = 1 }]
"""


def test_nothing_asked_is_the_plain_chain_and_the_truth_told():
    assert read_settings({}) == Settings(
        box=box("chain-4"), observation="symbolic", plant="symbolic", channels=(), max_steps=20, shuffle=False,
        steps_left=False, step_cost=0.0, truth=False,
    )  # fmt: skip
    assert read_settings({}).chain == (TextChannel(),)
    assert not read_settings({}).has_camera


def test_what_is_seen_comes_from_the_plant_as_it_is_asked_for():
    asked = {"plant": "twin?width=96&height=72&pose_error=0.004"}
    seen = [read_settings(asked | {"observation": observation}) for observation in ("symbolic", "rgb", "rgbd")]
    assert [settings.chain for settings in seen] == [
        (TextChannel(),), (CameraChannel(),), (CameraChannel(depth="turbo"),),
    ]  # fmt: skip
    assert [settings.picture_size for settings in seen] == [(72, 96)] * 3
    assert all(settings.has_camera for settings in seen)
    plan = seen[2].plan(1, 1, 2)
    assert (plan.plant, plan.modality) == (asked["plant"], "rgbd")
    assert (plan.key, seen[0].plan(1, 1, 2).key) == (
        "lockbox/gymnasium/rgbd/p=0/rep=1/trial=2", "lockbox/gymnasium/p=0/rep=1/trial=2",
    )  # fmt: skip


def test_a_box_is_a_name_a_value_or_a_file(tmp_path):
    path = tmp_path / "two.toml"
    path.write_text(FILE, "utf-8")
    assert read_settings({"box": "chain-3"}).box == read_settings({"box": box("chain-3")}).box == box("chain-3")
    assert read_settings({"box": str(path)}).box.names == read_settings({"box": path}).box.names == ("door", "bar")


def test_a_mapping_is_the_channel_that_it_describes():
    flip = {"channel": "OutcomeFlip", "p": 0.25, "persistence": "sticky"}
    read = read_settings({"channels": [flip, OutcomeFlip(p=0.5), {"channel": "TextChannel"}]})
    assert read.channels == (OutcomeFlip(p=0.25, persistence="sticky"), OutcomeFlip(p=0.5), TextChannel())


def test_only_what_is_told_has_entries():
    assert read_settings({}).sizes == (4, 5, 3, 2, 2, 2, 2)
    assert read_settings({"steps_left": True, "max_steps": 9, "box": "chain-2"}).sizes == (2, 3, 3, 2, 2, 10)
    hidden = {"channels": [OutcomeFlip(persistence="outcome-only")]}
    assert read_settings(hidden).sizes == (4, 5, 3)
    assert not read_settings(hidden).tells_positions


SEEN = {"observation": "rgb", "plant": "fast-twin"}


@dataclass(frozen=True)
class NotAChannel:
    p: float = 0.5


@pytest.mark.parametrize(
    ("asked", "kind", "message"),
    [
        ({"observation": "rgb"}, BadValue, "observation: got 'rgb', expected symbolic, or plant='fast-twin' or 'twin'"),
        ({"observation": "depth"}, UnknownName, "no observation is called 'depth'; there are: symbolic, rgb, rgbd"),
        ({"plant": "twins"}, UnknownName, "no plant is called 'twins' (did you mean 'twin'?)"),
        ({"plant": "twin?heigth=99"}, UnknownName, "no option of twin is called 'heigth' (did you mean 'height'?)"),
        ({"plant": "fast-twin?width=9"}, BadValue, "width: got 9, expected a number from 64 to 4096"),
        (SEEN | {"steps_left": True}, BadValue, "steps_left: got True, expected False where pictures are seen"),
        (SEEN | {"channels": [OutcomeFlip(p=0.2)]}, BadValue, "channel: got OutcomeFlip(p=0.2, persistence='transient', only='any'"),
        (SEEN | {"channels": [TextChannel()]}, BadValue, "channel: got TextChannel(tell='both', form='words', places=False), expected none that changes reports"),
        ({"max_step": 3}, UnknownName, "no setting of the environment is called 'max_step' (did you mean 'max_steps'?"),
        ({"box": "chain-99"}, UnknownName, "no box is called 'chain-99'"),
        ({"box": 4}, BadValue, "box: got 4, expected a name, a Lockbox or the path of a TOML file"),
        ({"box": "none.toml"}, BadFile, "none.toml: "),
        ({"max_steps": 0}, BadValue, "max_steps: got 0, expected a whole number from 1 to 10000"),
        ({"max_steps": 10_001}, BadValue, "max_steps: got 10001"),
        ({"max_steps": True}, BadValue, "max_steps: got True"),
        ({"max_steps": 2.5}, BadValue, "max_steps: got 2.5"),
        ({"shuffle": 1}, BadValue, "shuffle: got 1, expected True or False"),
        ({"step_cost": -0.1}, BadValue, "step_cost: got -0.1, expected a number from 0 on"),
        ({"step_cost": float("nan")}, BadValue, "step_cost: got nan"),
        ({"info": "all"}, BadValue, "info: got 'all', expected None or 'truth'"),
        ({"channels": "OutcomeFlip"}, BadValue, "channels: got 'OutcomeFlip', expected a list of channels"),
        ({"channels": {"channel": "OutcomeFlip"}}, BadValue, "channels: got {'channel': 'OutcomeFlip'}, expected a list"),
        ({"channels": [OutcomeFlip]}, BadValue, "channel: got <class"),
        ({"channels": [NotAChannel()]}, BadValue, "channel: got NotAChannel(p=0.5), expected a channel, or a mapping"),
        ({"channels": [{"p": 0.2}]}, BadValue, "channel: got {'p': 0.2}, expected a channel, or a mapping such as"),
        ({"channels": [{"channel": "Flip"}]}, UnknownName, "no channel is called 'Flip'"),
        ({"channels": [{"channel": "OutcomeFlip", "q": 1}]}, UnknownName, "no setting of OutcomeFlip is called 'q'"),
        ({"channels": [{"channel": "OutcomeFlip", "p": 2}]}, BadValue, "flip rate p: got 2"),
        ({"channels": [{"channel": "OutcomeFlip", "p": "a"}]}, BadValue, "channel: got {'channel': 'OutcomeFlip', 'p'"),
    ],
)  # fmt: skip
def test_what_does_not_exist_is_refused_in_one_line(asked, kind, message):
    with pytest.raises(kind) as mistake:
        read_settings(asked)
    assert isinstance(mistake.value, UserMistake)
    assert str(mistake.value).startswith(message)
    assert "\n" not in str(mistake.value)
