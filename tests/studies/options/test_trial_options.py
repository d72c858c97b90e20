"""The options of one trial are those of a study: same names, same types, same trial."""

import inspect
from dataclasses import replace
from pathlib import Path

import pytest

import lockprobe
from lockprobe.boxes.boxfile import toml_of
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadValue
from lockprobe.interventions.done import Tremble
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import OF_A_TRIAL, study, trial_study
from lockprobe.studies.running.single import run_trial
from lockprobe.trial.condition import Condition

OF_TRIALS = {"repetition", "trial", "pictures"}
OF_STUDIES = {
    "study", "trials", "strategy_trials", "repetitions", "full", "as_paper", "parts", "name", "sweep", "readings",
    "until", "most", "boxes", "contrasts",
}  # fmt: skip


def test_a_trial_has_the_options_of_a_study_and_its_own_place_in_it():
    assert inspect.signature(run_trial).parameters.keys() == (StudyOptions.model_fields.keys() - OF_STUDIES) | OF_TRIALS
    assert OF_A_TRIAL | {"agent", "pictures"} == inspect.signature(run_trial).parameters.keys()


@pytest.mark.parametrize(
    "asked",
    [
        {},
        {"p": 0.3, "flip": "sticky", "seed": 7},
        {"condition": "tremble?p=0.2 + drop?p=0.3", "box": "chain-5", "max_steps": 9, "assessment": False},
        {"condition": "tremble?p=0.2", "modality": "symbolic?tell=state", "layout": "shuffled", "shuffle": "never"},
        {"modality": "symbolic?tell=outcome", "p": 0.4},
    ],
)
def test_a_trial_is_that_of_the_study_with_the_same_options(asked):
    there = {name: [value] if name == "p" else value for name, value in asked.items()}
    planned = study("flips", agent="human-inspired", trials=3, repetitions=2, **({"p": [0.0]} | there))
    condition = planned.conditions[-1]
    plan = planned.plan("human-inspired", condition, 2, 3)
    alone = trial_study({**asked, "trial": 3, "repetition": 2}, agent="human-inspired")
    mine = alone.plan("human-inspired", alone.conditions[0], 2, 3)
    assert len(alone.conditions) == 1
    assert replace(plan, study="trial") == mine


def test_a_condition_is_a_spec_an_object_or_a_list():
    tremble = Tremble(p=0.2)
    asked = ("tremble?p=0.2", Condition(interventions=(tremble,)), (tremble,), [tremble])
    assert len({run_trial(condition=one).key for one in asked}) == 1
    assert len({run_trial(condition=one).key for one in (None, "", (), "truth", Condition())}) == 1


def test_nothing_is_as_if_it_were_left_out():
    assert run_trial(**dict.fromkeys({*OF_A_TRIAL, "agent", "pictures"})) == run_trial()


@pytest.mark.parametrize(
    ("asked", "kind", "message"),
    [
        ({"trails": 3}, TypeError, "run_trial() got an unexpected keyword argument 'trails'"),
        ({"repetition": "x"}, BadValue, "repetition: got 'x', expected a whole number"),
        ({"trial": 0}, BadValue, "trial: got 0, expected a whole number from 1 to 1000000"),
        ({"p": [0.1, 0.2]}, BadValue, "p: got [0.1, 0.2], expected a number"),
        ({"modality": ["rgb"]}, BadValue, "modality: got ['rgb'], expected a text"),
        ({"box": 4}, BadValue, "box: got 4, expected a name, a Lockbox or the path of a TOML file"),
        ({"agent": 4}, BadValue, "agent: got 4, expected an agent spec, or an object with facts and decide()"),
        ({"condition": [4]}, BadValue, "condition: got [4], expected specs with plus signs between, a Condition"),
        ({"shuffle": "x"}, BadValue, "shuffle: got 'x', expected one of trial, study, never"),
        ({"plant": "x" * 2000}, BadValue, "plant: got 'xxx"),
        ({"condition": "tremble", "flip": "sticky"}, BadValue, "flip: got 'sticky', expected a flip rate p with it"),
        ({"condition": "rgb", "modality": "rgbd"}, BadValue, "modality: got 'rgbd', expected none with a condition"),
        ({"condition": "flip?p=0.1", "p": 0.2}, BadValue, "p: got 0.2, expected 0 with a condition that flips"),
    ],
)
def test_what_a_trial_cannot_be_asked_is_one_line(asked, kind, message):
    with pytest.raises(kind) as mistake:
        run_trial(**asked)
    assert str(mistake.value).startswith(message)
    assert "\n" not in str(mistake.value)


class TestBoxesOfStudies:
    ASKED = {"agent": "random", "p": [0.0], "trials": 2, "repetitions": 1}  # noqa: RUF012 - read only

    def test_a_box_is_a_name_a_path_or_an_object(self, tmp_path):
        path = tmp_path / "mine.toml"
        path.write_text(toml_of(box("fork")), "utf-8")
        made = [study(box=one, **self.ASKED) for one in ("fork", box("fork"), path, str(path))]
        assert {one.identity for one in made} == {study("flips", box="fork", **self.ASKED).identity}

    def test_a_study_of_an_object_is_written_and_resumed_like_any_other(self, tmp_path):
        mine = replace(box("fork"), name="mine")
        first = lockprobe.run_study(lockprobe.study(box=mine, **self.ASKED), tmp_path)
        more = lockprobe.run_study(lockprobe.study(box=mine, **self.ASKED), tmp_path)
        assert first == more == lockprobe.load(tmp_path)
        assert {trial.box for trial in first} == {"mine"}
        from lockprobe.studies.records.directory import read_study

        assert read_study(tmp_path).box == mine
        with pytest.raises(lockprobe.UserMistake, match="already holds a study with other settings"):
            lockprobe.run_study(lockprobe.study(box=replace(mine, target=mine.names[1]), **self.ASKED), tmp_path)

    @pytest.mark.parametrize(
        ("change", "why"),
        [
            ({"name": "my box"}, "one that a file can hold .name: expected a name"),
            ({"interlock": {name: ({"b": True},) for name in "t"} | {"b": ({"t": True},)}}, "one that can be played"),
        ],
    )
    def test_a_box_that_no_directory_could_hold_is_refused(self, change, why):
        joints = tuple(lockprobe.Joint(name=name, kind="prismatic") for name in "tb")
        mine = lockprobe.Lockbox(name="two", joints=joints, interlock={}, initial=(False, False), target="t")
        with pytest.raises(BadValue, match=f"^box: got .*, expected {why}"):
            study(box=replace(mine, **change), **self.ASKED)

    def test_files_name_boxes_by_text(self, tmp_path):
        path = Path(tmp_path / "mine.toml")
        path.write_text("[box]\nname = 'mine'\n", "utf-8")
        with pytest.raises(lockprobe.UserMistake, match="box: expected a name, a Lockbox or the path of a TOML file"):
            study(str(path))
