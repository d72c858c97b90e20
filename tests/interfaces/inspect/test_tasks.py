"""The tasks are the studies: samples, parameters, and mistakes in one line."""

import inspect
from importlib.metadata import entry_points

import pytest

from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study

tasks = pytest.importorskip("lockprobe.interfaces.inspect.tasks")

from lockprobe.agents.llm.inspect_internals import PrerequisiteError  # noqa: E402
from lockprobe.interfaces.inspect.samples import OPTIONS, SETTINGS  # noqa: E402


@pytest.mark.parametrize("task", [tasks.flips, tasks.modalities])
def test_all_options_of_a_study_are_parameters(task):
    parameters = set(inspect.signature(task).parameters)
    assert parameters == set(StudyOptions.model_fields) - {"study", "agent"} | {*OPTIONS, "unknown"}


def test_inspect_finds_the_tasks_by_the_name_of_the_package():
    (found,) = (entry for entry in entry_points(group="inspect_ai") if entry.name == "lockprobe")
    assert found.load() is tasks


def test_one_sample_is_one_trial_and_says_which():
    task = tasks.flips(p="0,0.4", trials=2, repetitions=2)
    assert [sample.id for sample in task.dataset][:3] == [
        "truth/rep=1/trial=1",
        "flip?p=0.4/rep=1/trial=1",
        "truth/rep=1/trial=2",
    ]
    assert len({sample.id for sample in task.dataset}) == 8
    for sample in task.dataset:
        said = sample.metadata
        assert sample.id == f"{said['condition']}/rep={said['repetition']}/trial={said['trial']}"
        assert f"The target joint: {sample.target}" in sample.input


@pytest.mark.parametrize(
    "given",
    [
        {"p": [0.1], "trials": 3, "repetitions": 1, "seed": 7, "max_steps": 9, "flip": "sticky"},
        {"box": "random-5-3", "layout": "shuffled", "shuffle": "never", "assessment": False, "trials": 1},
        {"full": True},
        {},
    ],
)
def test_parameters_are_the_options_of_run(given):
    settings = tasks.flips(**given).metadata[SETTINGS]
    planned = study(StudyOptions(study="flips", agent=["llm:a/b"], **given))
    assert settings == {**planned.settings(), "agents": []}


def test_modalities_has_the_extent_of_the_paper():
    ids = [sample.id for sample in tasks.modalities().dataset]
    assert len(ids) == 30
    assert {name.split("/")[0] for name in ids} == {"rgb", "rgbd", "truth"}


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"p": "0,x"}, "p: got '0,x'"),
        ({"p": [0, 2]}, "got 2.0"),
        ({"flip": "never"}, "flip: got 'never', expected one of transient, sticky, outcome-only"),
        ({"box": "nope"}, "no box is called 'nope'"),
        ({"modality": "smell"}, "no modality is called 'smell'"),
        ({"repairs": 99}, "repairs: got 99"),
        ({"repairs": True}, "repairs: got True"),
        ({"trials": True}, "trials: got True"),
        ({"seed": -1}, "seed: got -1"),
        ({"p": ""}, "p: got ''"),
        ({"detail": "none"}, "detail: got 'none'"),
        ({"until": "decided"}, "until: got 'decided', expected none with Inspect, which plays all samples"),
    ],
)
def test_a_mistake_is_one_line(given, said):
    with pytest.raises(PrerequisiteError) as raised:
        tasks.flips(**given)
    assert said in str(raised.value.message)
    assert "\n" not in str(raised.value.message)
