"""A study is one object, and its file is its dump: its trials, its identity, its limits, its boxes, its names."""

import json
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest
from builders import modality_study, play_study, small_study, write_study

from lockprobe import run_study, study
from lockprobe.boxes.box import bits
from lockprobe.foundation.errors import BadFile, SettingsChanged
from lockprobe.interventions.conditions import flips
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import load
from lockprobe.studies.study import settings_of
from lockprobe.trial.condition import Condition
from lockprobe.trial.record import STATES

GOLDEN = Path(__file__).parents[1] / "golden" / "identities.json"
STUDY = study("flips", agent="random", trials=2, repetitions=2, p=[0, 0.4])
MODAL = modality_study(("viewer", "random"), trials=3)


def test_identity_changes_with_every_setting():
    changes = {
        "agents": ("round-robin",), "repetitions": 1, "trials": 3, "max_steps": 10,
        "seed": 2, "shuffle": "never", "boxes": study("flips", agent="random", box="chain-3").boxes,
        "layout": "shuffled", "plant": "fast-twin", "strategy_trials": 7,
    }  # fmt: skip
    acting = [flips((0.0,)), flips((0.0, 0.4), "integrated"), (Condition(name="mine"),)]
    changed = [{name: value} for name, value in changes.items()] + [{"conditions": one} for one in acting]
    identities = {replace(STUDY, **change).identity for change in changed}
    assert len(identities | {STUDY.identity}) == len(changed) + 1


def test_identities_are_pinned():
    """They name directories, and stand under preregistrations as hashes: a change of one is a change of the formats."""
    pinned = json.loads(GOLDEN.read_text())
    found = {"flips": STUDY, "modalities on one panel": MODAL}
    assert pinned == {name: one.identity for name, one in found.items()}
    assert pinned != {name: replace(one, seed=2).identity for name, one in found.items()}


def test_a_shuffled_trial_records_its_own_panel():
    asked = {"agent": ["random", "human-inspired"], "trials": 6, "repetitions": 2, "p": [0, 0.4]}
    planned = study("flips", layout="shuffled", **asked)
    for trial in play_study(planned):
        box = planned.plan(trial.agent, planned.labelled(trial.condition), trial.repetition, trial.trial).box
        assert trial.joints == box.names
        configuration = box.initial
        for step in trial.steps:
            assert step.state == bits(configuration)
            configuration, moved = box.attempt(configuration, box.names.index(step.joint))
            assert step.moved == moved


def test_an_agent_that_reads_reports_plays_no_pictures():
    assert (MODAL.modalities_of("viewer"), MODAL.modalities_of("random")) == (
        ("rgb", "rgbd", "symbolic"),
        ("symbolic",),
    )
    looking, reading = (list(MODAL.plans(agent)) for agent in MODAL.agents)
    assert [plan.modality for plan in looking] == ["rgb", "rgbd", "symbolic"] * 3
    assert [plan.modality for plan in reading] == ["symbolic"] * 3
    assert MODAL.size == len(looking) + len(reading) == 12
    assert {plan.plant for plan in looking} == {"fast-twin"}


def test_trials_take_turns_on_the_boxes_each_with_luck_of_its_own(tmp_path):
    planned = study(
        "flips", box="chain-4,fork,reset", agent=["human-inspired", "random"], p="0,0.4", trials=2, repetitions=1
    )
    trials = run_study(planned, tmp_path / "study")
    assert read_study(tmp_path / "study") == planned
    assert Counter((trial.group, trial.box) for trial in trials) == dict.fromkeys(
        ((agent, name) for agent in ("human-inspired", "random") for name in ("chain-4", "fork", "reset")), 4
    )
    names = ("chain-4", "fork", "reset")
    assert {(trial.trial, trial.box) for trial in trials} == {(i, names[(i - 1) % 3]) for i in range(1, 7)}
    assert len({trial.labels for trial in trials}) > 3  # of equal trials of two boxes, too
    assert run_study(planned, tmp_path / "study") == trials


# -- its file --


@pytest.mark.parametrize(
    "planned",
    [
        small_study(),
        replace(small_study(), layout="shuffled"),
        modality_study(["viewer"], trials=1),
        study("flips", agent="mine=random", condition=["told the truth=truth", "lies=flip?p=0.4"], until="±10"),
    ],
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
        ("conditions", [SAID | {"name": "a\nb"}], "visible characters"),
        ("conditions", [SAID | {"p": 0.4}], "conditions.0.p"),
        ("conditions", [acting(0.0), acting(1e-300)], "expected 0, or a number from 1e-09"),
        ("agents", [["random"]], "agents.0"),
        ("agents", ["random", "random"], "every one once"),
        ("agents", ["x" * 1001], "agents.0: expected at most 1000 characters"),
        ("trials", -3, "trials"),
        ("trials", 10**30, "trials"),
        ("boxes", None, "boxes: expected a list"),
        ("boxes", [{}], "name: is missing"),
        ("boxes", [], "every one once"),
        ("layout", "round", "layout"),
        ("strategy_trials", 0, "strategy_trials"),
        ("conditions", [SAID | {"modality": "rgb"}], "a plant with a camera"),
        ("conditions", [SAID | {"modality": "smoke"}], "no modality is called 'smoke'"),
        ("conditions", [SAID, acting(7)], "the flip rate of flip[?]p=7: got 7.0, expected a number from 0 to 1"),
        ("earlier", [{"repetitions": 9, "trials": 1, "strategy_trials": None}], "a study that was no larger than"),
        ("plant", "steam", "no plant"),
        ("colour", "red", "colour"),
        *((name, ..., f"{name}: is missing") for name in small_study().settings()),
    ],
)
def test_settings_that_are_none_are_refused(tmp_path, name, value, message):
    found = settings_of(small_study(["random", "human-inspired"])) | {name: value}
    (tmp_path / "study.json").write_text(json.dumps({key: one for key, one in found.items() if one is not ...}))
    with pytest.raises(BadFile, match=message):
        read_study(tmp_path)


@pytest.mark.parametrize("content", ["[" * 100_000, "{", "[]", "null", ""])
def test_damaged_settings_are_refused(tmp_path, content):
    (tmp_path / "study.json").write_text(content)
    with pytest.raises(BadFile, match="study.json"):
        read_study(tmp_path)


# -- names of its agents --

SPEC = "human-inspired?lapse=0.1"


def small(*agents):
    return study("flips", agent=list(agents), p=[0, 0.4], trials=2, repetitions=1)


def test_a_name_changes_no_draw():
    called, plain = play_study(small(f"careful={SPEC}", "random")), play_study(small(SPEC, "random"))
    assert [replace(one, key="", called="") for one in called] == [replace(one, key="") for one in plain]


@pytest.mark.parametrize("other", ["kind", ""])
def test_another_name_is_told_as_one(tmp_path, other):
    write_study(tmp_path, small(f"careful={SPEC}", "random"))
    renamed = small(f"{other}={SPEC}" if other else SPEC, "random")
    with pytest.raises(SettingsChanged, match=f"name of {SPEC[:8]}.* is 'careful' there, '{other or SPEC[:8]}"):
        run_study(renamed, tmp_path)
    path = tmp_path / "study.json"
    path.write_text(json.dumps(renamed.settings()))
    with pytest.raises(BadFile, match="holds flips/careful/truth.*which is no trial of the study in study.json"):
        load(tmp_path)
