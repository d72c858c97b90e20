"""What can be asked for, and the one line for what cannot."""

from dataclasses import dataclass

import pytest

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadFile, BadValue, UnknownName, UserMistake
from lockprobe.interfaces.gymnasium.settings import NOT_HERE, read_settings
from lockprobe.interventions.camera import CameraChannel
from lockprobe.interventions.done import Tremble
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.interventions.words import TextChannel
from lockprobe.studies.modality import interventions_for
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import OF_A_TRIAL, trial_study
from lockprobe.trial.condition import Condition

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
    read = read_settings({})
    assert (read.observation, read.study.plant, read.study.max_steps) == ("symbolic", "symbolic", 20)
    assert read.study.box == box("chain-4")
    assert (read.steps_left, read.step_cost, read.truth) == (False, 0.0, False)
    assert read.study.shuffle == "never"
    assert read == read_settings(dict.fromkeys(("box", "p", "condition", "shuffle", "observation")))
    assert read_settings({}).chain == (TextChannel(),)
    assert read_settings({}).picture_size is None


def test_what_is_seen_comes_from_the_plant_as_it_is_asked_for():
    asked = {"plant": "twin?width=96&height=72&pose_error=0.004"}
    seen = [read_settings(asked | {"observation": observation}) for observation in ("symbolic", "rgb", "rgbd")]
    assert [settings.chain for settings in seen] == [
        (TextChannel(),), (CameraChannel(),), (CameraChannel(depth="turbo"),),
    ]  # fmt: skip
    assert [settings.picture_size for settings in seen] == [(96, 72)] * 3
    plan = seen[2].plan(1, 1, 2)
    assert (plan.plant, plan.modality) == (asked["plant"], "rgbd")
    assert (plan.key, seen[0].plan(1, 1, 2).key) == (
        "lockbox/gymnasium/rgbd/rep=1/trial=2", "lockbox/gymnasium/symbolic/rep=1/trial=2",
    )  # fmt: skip


def test_a_box_is_a_name_a_value_or_a_file(tmp_path):
    path = tmp_path / "two.toml"
    path.write_text(FILE, "utf-8")
    assert (
        read_settings({"box": "chain-3"}).study.box
        == read_settings({"box": box("chain-3")}).study.box
        == box("chain-3")
    )
    assert (
        read_settings({"box": str(path)}).study.box.names
        == read_settings({"box": path}).study.box.names
        == ("door", "bar")
    )


def test_only_what_is_told_has_entries():
    assert read_settings({}).sizes == (4, 5, 3, 2, 2, 2, 2)
    assert read_settings({"steps_left": True, "max_steps": 9, "box": "chain-2"}).sizes == (2, 3, 3, 2, 2, 10)
    assert not read_settings({"modality": "symbolic?tell=outcome"}).tells_positions


SEEN = {"observation": "rgb", "plant": "fast-twin"}


@dataclass(frozen=True)
class NotAChannel:
    p: float = 0.5


@pytest.mark.parametrize(
    ("asked", "kind", "message"),
    [
        ({"observation": "rgb"}, BadValue, "modality: got 'rgb', expected a plant with a camera, fast-twin or twin, not symbolic"),
        ({"observation": "depth"}, UnknownName, "no observation is called 'depth'; there are: symbolic, rgb, rgbd"),
        ({"plant": "twins"}, UnknownName, "no plant is called 'twins' (did you mean 'twin'?)"),
        ({"plant": "twin?heigth=99"}, UnknownName, "no option of twin is called 'heigth' (did you mean 'height'?)"),
        ({"plant": "fast-twin?width=9"}, BadValue, "width: got 9, expected a number from 64 to 4096"),
        (SEEN | {"steps_left": True}, BadValue, "steps_left=True cannot be combined with pictures"),
        ({"max_step": 3}, UnknownName, "no setting of the environment is called 'max_step' (did you mean 'max_steps'?"),
        ({"box": "chain-99"}, UnknownName, "no box is called 'chain-99'"),
        ({"box": 4}, BadValue, "box: got 4, expected a name, a Lockbox or the path of a TOML file"),
        ({"box": "none.toml"}, BadFile, "none.toml: "),
        ({"max_steps": 0}, BadValue, "max_steps: got 0, expected a whole number from 1 to 10000"),
        ({"max_steps": 10_001}, BadValue, "max_steps: got 10001"),
        ({"max_steps": True}, BadValue, "max_steps: got True"),
        ({"max_steps": 2.5}, BadValue, "max_steps: got 2.5"),
        ({"shuffle": "cards"}, BadValue, "shuffle: got 'cards', expected one of trial, study, never"),
        ({"steps_left": 1}, BadValue, "steps_left: got 1, expected True or False"),
        ({"step_cost": -0.1}, BadValue, "step_cost: got -0.1, expected a number of at least 0"),
        ({"step_cost": float("nan")}, BadValue, "step_cost: got nan"),
        ({"condition": [NotAChannel()]}, BadValue, "condition: got [NotAChannel(p=0.5)], expected specs with plus signs between"),
        ({"info": "all"}, BadValue, "info: got 'all', expected None or 'truth'"),
    ],
)  # fmt: skip
def test_what_does_not_exist_is_refused_in_one_line(asked, kind, message):
    with pytest.raises(kind) as mistake:
        read_settings(asked)
    assert isinstance(mistake.value, UserMistake)
    assert str(mistake.value).startswith(message)
    assert "\n" not in str(mistake.value)


def test_every_option_of_a_study_and_of_a_trial_is_played_or_refused():
    for name in {*StudyOptions.model_fields, *OF_A_TRIAL, "pictures"}:
        if name in NOT_HERE:
            with pytest.raises(BadValue, match=f"^{name}: got 1, expected "):
                read_settings({name: 1})
        else:
            assert name in OF_A_TRIAL
            read_settings({name: None})


def test_the_condition_is_that_of_the_trial():
    for asked in (
        {"condition": "flip?p=0.3 + tremble?p=0.1"},
        {"condition": [OutcomeFlip(p=0.3, only="moved"), Tremble(p=0.1)]},
        {"condition": Condition(interventions=(Tremble(p=0.1),), name="mine"), "p": 0.2, "flip": "sticky"},
        {"modality": "symbolic?tell=state", "p": 0.2},
        {"condition": "tremble?p=0.1 + rgb?p=0.4", "plant": "fast-twin"},
        {"observation": "rgbd", "p": 0.4, "plant": "fast-twin"},
    ):
        here = read_settings(asked)
        words = {"modality" if name == "observation" else name: value for name, value in asked.items()}
        unsaid = not isinstance(asked.get("condition"), Condition) and "rgb" not in str(asked.get("condition"))
        there = trial_study(({"modality": "symbolic"} if unsaid else {}) | words, agent="x")
        assert here.study.conditions == there.conditions
        assert here.chain == interventions_for(there.conditions[0])


@dataclass(frozen=True)
class Silent:
    def perceive(self, percept, past, task, rng):
        return percept


@dataclass(frozen=True)
class Loud(Silent):
    always_tells = True


def test_what_is_told_shapes_the_space():
    assert read_settings({"modality": "symbolic?tell=state"}).sizes == (4, 5, 1, 2, 2, 2, 2)
    assert read_settings({"modality": "symbolic?tell=outcome"}).sizes == (4, 5, 3)
    assert read_settings({"condition": "drop?p=0.1"}).sizes == (4, 5, 3, 3, 3, 3, 3)
    assert read_settings({"condition": [Silent()]}).sizes == (4, 5, 3, 3, 3, 3, 3)
    for tells in ("flip?p=0.1 + tremble", "correction?p=0.3", [Loud()]):
        assert read_settings({"condition": tells}).sizes == (4, 5, 3, 2, 2, 2, 2)
    assert read_settings({"p": 0.2, "flip": "outcome-only"}).sizes == (4, 5, 3)


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"condition": "nudge"}, "condition: got 'nudge', expected interventions on reports or actions: an observation holds no words"),
        ({"condition": "flip?p=0.2 + history?last=1"}, "condition: got 'history"),
        ({"condition": "drop?p=0.3", "observation": "rgb", "plant": "fast-twin"}, "condition: got 'drop?p=0.3 + rgb', expected a condition without missing reports"),
        ({"observation": "rgb", "modality": "rgb?blur=8"}, "observation= cannot be combined with modality="),
        ({"condition": "flip?p=0.2", "p": 0.2}, "p: got 0.2, expected 0 with a condition that flips reports itself"),
        ({"condition": "tremble", "flip": "sticky"}, "flip: got 'sticky', expected a flip rate p with it"),
        ({"condition": "rgb", "modality": "rgbd"}, "modality: got 'rgbd', expected none with a condition that says rgb itself"),
        ({"modality": "symbolic?tell=state", "p": 0.2, "flip": "outcome-only"}, "flip: got 'outcome-only'"),
        ({"modality": ["rgb"]}, "modality: got ['rgb'], expected a text"),
        ({"p": [0.1, 0.2]}, "p: got [0.1, 0.2], expected a number"),
        ({"condition": 3}, "condition: got 3, expected specs with plus signs between, a Condition, or a list"),
        ({"layout": "round"}, "layout: got 'round', expected one of fixed, dealt, shuffled"),
    ],
)  # fmt: skip
def test_what_does_not_go_together_is_refused_in_one_line(asked, message):
    with pytest.raises(BadValue) as mistake:
        read_settings(asked)
    assert str(mistake.value).startswith(message)
    assert "\n" not in str(mistake.value)
