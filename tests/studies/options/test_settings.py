"""Settings on disk are a study again, or are refused in one line."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
from builders import modality_study, small_study, write_study

from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.study import study_from
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
        ("conditions", [acting(0.0), acting(1e-300)], "differ by 0.000001"),
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


def test_a_long_spec_is_refused():
    long = "llm:openai-api/fake/" + "x" * 1000
    with pytest.raises(BadValue, match="^agent: got .*llm:.*…., expected at most 1000 characters$"):
        study("flips", agent=[long])
    with pytest.raises(BadValue, match="^plant: "):
        study("flips", plant="twin?" + "x" * 1000)


@pytest.mark.parametrize(
    ("acting", "message"),
    [
        ({"spec": "nudge + flip?p=0.4"}, "intervention: got 'nudge \\+ flip.p=0.4', expected one"),
        ({"spec": "flip?p=0.4", "doses": ["q"]}, "dose q of flip.p=0.4: got '', expected a number among its options"),
        ({"spec": "flip?p=0.4&others=kept", "doses": ["others"]}, "dose others of .*: got 'kept'"),
    ],
)
def test_an_intervention_of_settings_is_one_with_a_number_for_its_dose(acting, message):
    condition = {"name": "", "interventions": [acting], "modality": "symbolic?tell=state"}
    settings = study("flips", agent="random", p=[0]).settings() | {"conditions": [condition]}
    with pytest.raises(BadFile, match=message):
        study_from(json.dumps(settings).encode(), Path("study.json"))
