"""Settings on disk are a study again, or are refused in one line."""

import json
from dataclasses import replace

import pytest
from builders import modality_study, play_study, small_study, write_study

from lockprobe.errors import BadFile, BadValue
from lockprobe.studies.settings import read_study
from lockprobe.studies.study_options import StudyOptions
from lockprobe.studies.studyfile import study


@pytest.fixture
def directory(tmp_path):
    return write_study(tmp_path / "study", small_study(["random", "human-inspired"]))


def test_a_study_is_read_back(directory):
    assert read_study(directory) == small_study(["random", "human-inspired"])


def test_a_study_of_shuffled_layouts_is_read_back(tmp_path):
    shuffled = replace(small_study(["random"]), layout="shuffled")
    assert read_study(write_study(tmp_path / "study", shuffled)) == shuffled


def test_a_study_of_modalities_is_read_back(tmp_path):
    planned = modality_study(["viewer"], trials=1)
    assert read_study(write_study(tmp_path / "study", planned, [])) == planned


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("p", ["0"], "p.0"),
        ("p", [0, None], "p.1"),
        ("p", [0, 5], "p.1"),
        ("p", [], "at least one"),
        ("p", [0.0, 1e-300], "differ by 0.000001"),
        ("agents", [["random"]], "agents.0"),
        ("agents", ["random", "random"], "every one once"),
        ("trials", -3, "trials"),
        ("trials", 0, "trials"),
        ("trials", True, "trials"),
        ("trials", 10**30, "trials"),
        ("box", None, "box"),
        ("box", {}, "name"),
        ("identity", 99, "settings of version 99"),
        ("flip", "often", "flip"),
        ("layout", "round", "layout"),
        ("modalities", ["rgb"], "a plant with a camera"),
        ("modalities", ["smell"], "no modality"),
        ("modalities", "rgb", "modalities"),
        ("plant", "steam", "no plant"),
        ("colour", "red", "colour"),
    ],
)
def test_settings_that_are_none_are_refused(directory, name, value, message):
    path = directory / "study.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {name: value}))
    with pytest.raises(BadFile, match=message):
        read_study(directory)


@pytest.mark.parametrize("content", ["[" * 100_000, "{", "[]", "null", ""])
def test_damaged_settings_are_refused(directory, content):
    (directory / "study.json").write_text(content)
    with pytest.raises(BadFile, match="study.json"):
        read_study(directory)


@pytest.mark.parametrize(
    "change",
    [
        {"seed": 9},
        {"flip": "sticky"},
        {"budget": 19},
        {"study": "other"},
        {"p": 0.6},
        {"trial": 3},
        {"agent": "random"},
    ],
)
def test_a_trial_of_other_settings_is_not_one_of_the_study(change):
    study = small_study(["human-inspired"])
    trial = play_study(study)[0]
    assert study.asks_for(trial)
    assert not study.asks_for(replace(trial, **change))


def test_a_long_spec_is_refused_where_it_is_asked_for_and_read_where_it_was_taken(directory):
    long = "llm:openai-api/fake/" + "x" * 1000
    with pytest.raises(BadValue, match="^agent: got 'llm:.*…', expected at most 1000 characters; these are 1020$"):
        study(StudyOptions(agent=[long]))
    with pytest.raises(BadValue, match="^plant: "):
        study(StudyOptions(plant="twin?" + "x" * 1000))
    path = directory / "study.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"agents": [long]}))
    assert read_study(directory).agents == (long,)
