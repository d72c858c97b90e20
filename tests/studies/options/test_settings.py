"""Options, names and settings: what a study is made of, and what is refused in one line."""

import inspect
import json
from dataclasses import replace
from pathlib import Path

import pytest
from builders import modality_study, play_study, small_study, write_study

import lockprobe
from lockprobe.boxes.boxfile import toml_of
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadFile, BadValue, SettingsChanged
from lockprobe.interventions.asked_and_done import Tremble
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import OF_A_TRIAL, study, trial_study
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.merge import gather
from lockprobe.studies.records.read_records import load
from lockprobe.studies.running.runner import run_study
from lockprobe.studies.running.single import run_trial
from lockprobe.trial.condition import Condition
from lockprobe.trial.record import STATES


@pytest.fixture
def directory(tmp_path):
    return write_study(tmp_path / "study", small_study(["random", "human-inspired"]))


@pytest.mark.parametrize(
    "planned", [small_study(), replace(small_study(), layout="shuffled"), modality_study(["viewer"], trials=1)]
)
def test_a_study_is_read_back(tmp_path, planned):
    assert read_study(write_study(tmp_path / "study", planned, [])) == planned


SAID = {"name": "", "interventions": [], "modality": STATES}


def acting(p):
    """A flip as settings hold it."""
    return SAID | {"interventions": [{"spec": f"flip?p={p}", "doses": ["p"]}]}


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("conditions", None, "conditions: expected a list"),
        ("conditions", [], "at least one"),
        ("conditions", ["truth"], "conditions.0"),
        ("conditions", [SAID, SAID], "every one once"),
        ("conditions", [SAID | {"name": 3}], "conditions.0.name"),
        ("conditions", [SAID | {"name": "a\nb"}], "visible characters"),
        ("conditions", [SAID | {"p": 0.4}], "conditions.0.p"),
        ("conditions", [acting(0.0), acting(1e-300)], "expected 0, or a number from 1e-09"),
        ("conditions", [acting(1.5)], "flip rate p: got 1.5"),
        ("conditions", [acting("often")], "often"),
        ("agents", [["random"]], "agents.0"),
        ("agents", ["random", "random"], "every one once"),
        ("trials", -3, "trials"),
        ("trials", 0, "trials"),
        ("trials", True, "trials"),
        ("trials", 10**30, "trials"),
        ("boxes", None, "boxes: expected a list"),
        ("boxes", [{}], "boxes: name: is missing"),
        ("boxes", [], "every one once"),
        ("agents", ["x" * 1001], "agents.0: expected at most 1000 characters"),
        ("layout", "round", "layout"),
        ("assessment", 1, "assessment"),
        ("strategy_trials", 0, "strategy_trials"),
        ("conditions", [SAID | {"modality": "rgb"}], "a plant with a camera"),
        ("conditions", [SAID | {"modality": "smell"}], "no modality"),
        ("plant", "steam", "no plant"),
        ("colour", "red", "colour"),
    ],
)
def test_settings_that_are_none_are_refused(directory, name, value, message):
    path = directory / "study.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {name: value}))
    with pytest.raises(BadFile, match=message):
        read_study(directory)


@pytest.mark.parametrize("name", [*small_study().settings()])
def test_every_setting_is_there(directory, name):
    path = directory / "study.json"
    path.write_text(json.dumps({key: value for key, value in json.loads(path.read_text()).items() if key != name}))
    with pytest.raises(BadFile, match=rf"{name}: is missing"):
        read_study(directory)


@pytest.mark.parametrize("content", ["[" * 100_000, "{", "[]", "null", ""])
def test_damaged_settings_are_refused(directory, content):
    (directory / "study.json").write_text(content)
    with pytest.raises(BadFile, match="study.json"):
        read_study(directory)


SPEC = "human-inspired?lapse=0.1"


def small(*agents):
    return study("flips", agent=list(agents), p=[0, 0.4], trials=2, repetitions=1)


NAMED, PLAIN = small(f"careful={SPEC}", "random"), small(SPEC, "random")


def test_a_name_changes_no_draw():
    called, plain = play_study(NAMED), play_study(PLAIN)
    assert [replace(one, key="", called="") for one in called] == [replace(one, key="") for one in plain]


@pytest.mark.parametrize(
    ("agents", "said"),
    [
        (["a=random", "b=random"], "got 'b=random', expected random once: the same seed gives the same trials"),
        (["random", "b=random"], "got 'b=random', expected random once: the same seed gives the same trials"),
        (["a=random", "a=round-robin"], "agents: got \\['a', 'a'\\], expected at least one, and every one once"),
        (["random=human-inspired"], "another name: random is an agent"),
        (["me=participant"], "participant without a name"),
        ([" =random"], "NAME=SPEC"),
        (["a="], "NAME=SPEC"),
        (["a\x1b=random"], "visible characters"),
        ([f"{'a' * 201}=random"], "at most 200 visible characters"),
        ([f"human-inspired?lapse=0.{'1' * 200}"], "at most 200 characters, not 223, or a name: --agent 'NAME=SPEC'"),
    ],
)
def test_names_that_cannot_be_are_one_line(agents, said):
    with pytest.raises(BadValue, match=said) as caught:
        study("flips", agent=agents)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("other", ["kind", ""])
def test_another_name_is_told_as_one(tmp_path, other):
    write_study(tmp_path, NAMED)
    renamed = small(f"{other}={SPEC}" if other else SPEC, "random")
    with pytest.raises(SettingsChanged, match=f"name of {SPEC[:8]}.* is 'careful' there, '{other or SPEC[:8]}"):
        run_study(renamed, tmp_path)
    path = tmp_path / "study.json"
    path.write_text(json.dumps(renamed.settings()))
    with pytest.raises(BadFile, match="holds flips/careful/truth.*which is no trial of the study in study.json"):
        load(tmp_path)


def test_named_agents_that_were_played_apart_are_one_study(tmp_path):
    sources = [write_study(tmp_path / str(i), small(one)) for i, one in enumerate((f"careful={SPEC}", "b=random"))]
    gathered = gather(tmp_path / "both", sources)
    assert (gathered.taken, gathered.agents) == (8, ("careful", "b"))
    assert read_study(tmp_path / "both") == small(f"careful={SPEC}", "b=random")
    assert {trial.key for trial in load(tmp_path / "both")} == {
        one.key for one in play_study(read_study(tmp_path / "both"))
    }
    with pytest.raises(BadFile, match="name of random is 'c', not 'b'"):
        gather(tmp_path / "both", [write_study(tmp_path / "c", small("c=random"))])


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
