"""A study is data: its trials, its identity, its limits, its boxes."""

import json
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest
from builders import modality_study, play_study

from lockprobe import run_study
from lockprobe.boxes.box import bits
from lockprobe.boxes.families import ALIKE
from lockprobe.boxes.solve import optimum
from lockprobe.foundation.errors import BadFile, BadValue, UnknownName, UserMistake
from lockprobe.interventions.conditions import flips
from lockprobe.studies.options.agent_names import joined_agents
from lockprobe.studies.options.study_options import StudyOptions, read_options_file
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.study import settings_of, study_from
from lockprobe.trial.condition import Condition

GOLDEN = Path(__file__).parents[1] / "golden" / "identities.json"
STUDY = study(StudyOptions(agent=["random"], trials=2, repetitions=2, p=[0, 0.4]))


def test_plans_are_all_trials_once():
    keys = [plan.key for plan in STUDY.plans("random")]
    assert len(set(keys)) == len(keys) == STUDY.size == 8
    assert keys[0] == "flips/random/truth/rep=1/trial=1"
    assert keys[-1] == "flips/random/flip?p=0.4/rep=2/trial=2"


def test_identity_changes_with_every_setting():
    changes = {
        "agents": ("round-robin",), "repetitions": 1, "trials": 3, "max_steps": 10,
        "seed": 2, "shuffle": "never", "boxes": study(StudyOptions(agent=["random"], box="chain-3")).boxes,
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


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"seed": -1}, "seed: got -1, expected a whole number from 0"),
        ({"trials": 0}, "trials: got 0, expected a whole number from 1 to 1000000"),
        ({"p": [0.2, 0.2]}, r"p: got \[0.2, 0.2\], expected at least one, and every one once"),
        ({"p": [1.5]}, "flip rate p: got 1.5, expected a number from 0 to 1"),
        ({"agent": []}, r"agents: got \[\], expected at least one"),
        ({"max_steps": 0}, "max_steps: got 0, expected a whole number from 1"),
    ],
)
def test_settings_out_of_range_are_refused(change, message):
    with pytest.raises(BadValue, match="^" + message):
        study(StudyOptions(**({"agent": ["random"]} | change)))


def test_unknown_names_list_what_exists():
    with pytest.raises(UnknownName, match="^no study is called 'flip' .did you mean 'flips'.*; there are: flips"):
        study("flip")
    with pytest.raises(UnknownName, match="^no box is called 'chain-44'.*there are: chain-2, chain-3"):
        study(StudyOptions(agent=["random"], box="chain-44"))
    with pytest.raises(UnknownName, match="^no plant is called 'twn'"):
        study(StudyOptions(agent=["random"], plant="twn"))


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("trails = 2", "trails: no such key; keys are study, agent"),
        ('p = "all"', "p: expected a list"),
        ('agent = ["python:os:getcwd"]', "agent: python:os:getcwd would run code; name it on the command line"),
        ("p = [", "not TOML"),
        ("", "says nothing to play: a study file has at least a line such as study"),
        ("# all of it is still to come\n", "says nothing to play"),
        ('name = "mine"', "says nothing to play"),
        ('flip = "often"', "flip: expected 'transient', 'sticky', 'outcome-only', 'memoryless'"),
    ],
)
def test_what_is_wrong_in_a_study_file_is_named(tmp_path, text, reason):
    path = tmp_path / "mine.toml"
    path.write_text(text)
    with pytest.raises(BadFile) as mistake:
        read_options_file(path)
    assert str(mistake.value).startswith(f"{path}: {reason}")


def test_a_study_can_be_had_and_played_from_python(tmp_path):
    import lockprobe

    (tmp_path / "mine.toml").write_text('agent = ["random"]\np = [0]\ntrials = 2\nrepetitions = 1\n')
    trials = lockprobe.run_study(lockprobe.study(str(tmp_path / "mine.toml")), tmp_path / "d")
    assert trials == lockprobe.load(tmp_path / "d")
    rows = lockprobe.tidy(trials)
    assert len(rows) == sum(len(trial.steps) for trial in trials)
    assert set(lockprobe.__all__) <= set(dir(lockprobe)) | set(lockprobe._HOMES)
    with pytest.raises(AttributeError, match="module 'lockprobe' has no attribute 'bxo'"):
        _ = lockprobe.bxo


SHUFFLED = study(
    StudyOptions(agent=["random", "human-inspired"], trials=6, repetitions=2, p=[0, 0.4], layout="shuffled")
)


def test_a_shuffled_trial_records_its_own_panel():
    trials = play_study(SHUFFLED)
    for trial in trials:
        box = SHUFFLED.plan(trial.agent, SHUFFLED.labelled(trial.condition), trial.repetition, trial.trial).box
        assert trial.joints == box.names
        configuration = box.initial
        for step in trial.steps:
            assert step.state == bits(configuration)
            configuration, moved = box.attempt(configuration, box.names.index(step.joint))
            assert step.moved == moved


MODAL = modality_study(("viewer", "random"), trials=3)


def test_an_agent_that_reads_reports_plays_no_pictures():
    assert MODAL.modalities_of("viewer") == ("rgb", "rgbd", "symbolic")
    assert MODAL.modalities_of("random") == ("symbolic",)
    looking, reading = (list(MODAL.plans(agent)) for agent in MODAL.agents)
    assert [plan.modality for plan in looking] == ["rgb", "rgbd", "symbolic"] * 3
    assert [plan.modality for plan in reading] == ["symbolic"] * 3
    assert MODAL.size == len(looking) + len(reading) == 12
    assert {plan.plant for plan in looking} == {"fast-twin"}


@pytest.mark.parametrize(
    ("there", "asked", "together"),
    [
        (["participant"], ["random", "round-robin"], ("random", "round-robin", "participant")),
        (["participant", "random"], ["random", "participant"], ("participant", "random")),
        (["random"], ["random", "participant"], ("random", "participant")),
        (["random", "participant"], ["round-robin"], ("random", "round-robin", "participant")),
        (["random", "participant"], ["participant"], ("random", "participant")),
        (["random", "round-robin"], ["ideal-observer", "random"], ("random", "round-robin", "ideal-observer")),
    ],
)
def test_agents_that_are_asked_for_are_added_to_those_that_are_there(there, asked, together):
    assert joined_agents(there, asked) == together


def test_a_condition_is_played_in_every_modality_unless_it_says_its_own():
    planned = study(
        "modalities",
        agent="viewer",
        modality=["symbolic?tell=state", "symbolic", "rgb"],
        condition=["nudge", "warn + rgbd"],
    )
    assert [condition.label for condition in planned.conditions] == [
        "truth", "nudge", "symbolic", "nudge + symbolic", "rgb", "nudge + rgb", "rgbd", "warn + rgbd",
    ]  # fmt: skip


def test_a_named_condition_is_called_so_in_keys_and_settings(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(
        'name = "lab"\nagent = ["random"]\ntrials = 2\nrepetitions = 1\n'
        '[[condition]]\nname = "told the truth"\nspec = "truth"\n[[condition]]\nname = "lies"\nspec = "flip?p=0.4"\n'
    )
    planned = study(str(path))
    assert [plan.key for plan in planned.plans("random")][:2] == [
        "lab/random/told the truth/rep=1/trial=1", "lab/random/lies/rep=1/trial=1",
    ]  # fmt: skip
    assert study_from(json.dumps(settings_of(planned)).encode(), path) == planned


@pytest.mark.parametrize("key", ["condition", "sweep", "plant", "box"])
def test_a_study_file_runs_no_code(tmp_path, key):
    path = tmp_path / "mine.toml"
    path.write_text(f'{key} = "python:os:getcwd"')
    with pytest.raises(BadFile, match=f"{key}: python:os:getcwd would run code"):
        read_options_file(path)


@pytest.mark.parametrize(
    ("agent", "sweep", "said"),
    [
        ("random", "drop?p=0,1e-300", "drop.p of drop.p=1e-300: got 1e-300, expected 0, or a number from 1e-09"),
    ],
)
def test_a_dose_that_no_curve_can_be_fitted_to_is_refused(agent, sweep, said):
    with pytest.raises(BadValue, match=said):
        study("flips", agent=agent, sweep=sweep)


def test_options_in_python_are_those_of_the_command_line():
    with pytest.raises(UnknownName, match="no option is called 'trails' .did you mean 'trials'"):
        study("flips", trails=2)
    with pytest.raises(BadValue, match="trials: got 'many', expected a whole number"):
        study("flips", trials="many")


ASKED = {"agent": ["human-inspired", "random"], "p": [0, 0.4], "trials": 2, "repetitions": 1}


def test_trials_take_turns_on_the_boxes_each_with_luck_of_its_own(tmp_path):
    planned = study("flips", box="chain-4, fork,reset", **ASKED)
    trials = run_study(planned, tmp_path / "study")
    assert read_study(tmp_path / "study") == planned
    assert Counter((trial.group, trial.box) for trial in trials) == dict.fromkeys(
        ((agent, name) for agent in ("human-inspired", "random") for name in ("chain-4", "fork", "reset")), 4
    )
    assert {(trial.trial, trial.box) for trial in trials} == {
        (1, "chain-4"), (2, "fork"), (3, "reset"), (4, "chain-4"), (5, "fork"), (6, "reset"),
    }  # fmt: skip
    assert len({trial.labels for trial in trials}) > 3  # of equal trials of two boxes, too
    again = run_study(planned, tmp_path / "study")
    assert again == trials


def test_so_many_boxes_are_of_one_difficulty():
    planned = study("flips", boxes=6, agent="random", p=[0, 0.4])
    assert [optimum(one) for one in planned.boxes] == [4] * 6
    assert (planned.repetitions, planned.trials, planned.strategy_trials) == (1, 30, 120)
    assert planned.boxes == study("flips", boxes=9, agent="random").boxes[:6]
    assert {optimum(one) for one in study("why", box="random-5", boxes=3).boxes} == {5}


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"box": "chain-4,chain-4"}, "every one once"),
        ({"box": "chain-4,fork", "until": "decided"}, "none with several boxes"),
        ({"box": "chain-4", "boxes": 3}, "none with the box chain-4"),
        ({"box": "random-3", "boxes": 3}, "random-4 to random-8"),
        ({"box": []}, "at least one box"),
        ({"boxes": 1}, "boxes"),
        ({"box": "chain-4,nowhere"}, "nowhere"),
    ],
)
def test_what_has_no_meaning_is_refused(asked, said):
    with pytest.raises(UserMistake, match=said):
        study("flips", **asked)


def test_who_sees_places_learns_nothing_from_them():
    """People play several boxes of one difficulty, none of them twice; they and pictures have a new panel each trial."""
    people = study("flips", agent=["participant", "random"], p=[0, 0.4])
    assert (people.layout, [one.name for one in people.boxes]) == ("shuffled", list(ALIKE))
    assert study("flips", agent="participant", box="fork").layout == "shuffled"
    assert study("flips", agent="random", modality=["symbolic?places=yes"]).layout == "shuffled"
    assert study("flips", agent="viewer", modality=["rgb"], plant="fast-twin").layout == "shuffled"
    assert study("flips", agent="random").layout == "fixed"
    assert study("flips", agent="participant", layout="fixed", box="chain-4").layout == "fixed"
