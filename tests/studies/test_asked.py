"""The door of a study: options, a file or a name become one object, and what cannot be is refused in one line."""

import inspect
import json
import sys
from dataclasses import replace
from importlib import import_module, invalidate_caches
from itertools import combinations
from shutil import rmtree

import numpy as np
import pytest
from provider_server import here, replying, words

import lockprobe
from lockprobe import run_trial, study
from lockprobe.agents.llm.settings import Access
from lockprobe.boxes.boxfile import toml_of
from lockprobe.boxes.families import ALIKE, box
from lockprobe.boxes.solve import optimum
from lockprobe.foundation.errors import BadFile, BadValue, SettingsChanged, UnknownName, UserMistake
from lockprobe.interventions.asked_and_done import Tremble
from lockprobe.interventions.conditions import interventions_in
from lockprobe.interventions.flip import misread_rates, rates_of
from lockprobe.report.verify import verify
from lockprobe.statistics.design import ARMS, CROSSED
from lockprobe.statistics.misinterpretation import claim_counts
from lockprobe.studies.options.study_options import SHIPPED, StudyOptions
from lockprobe.studies.options.studyfile import preset, trial_study
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import load
from lockprobe.studies.running.runner import Limits, run_study
from lockprobe.trial.condition import Condition

TINY = {"agent": "random", "p": [0], "trials": 2, "repetitions": 1}


def labels(planned, agent=None):
    own = planned.conditions if agent is None else planned.conditions_of(agent)
    return [one.label for one in own]


PICTURED = {"modality": ["rgb"], "plant": "fast-twin"}


@pytest.mark.parametrize(
    ("name", "asked", "said"),
    [
        ("flip", {}, "no study is called 'flip' (did you mean 'flips'?); there are: flips, modalities, why, looks"),
        ("flips", {"trails": 2}, "no option is called 'trails' (did you mean 'trials'?)"),
        ("flips", {"trials": "many"}, "trials: got 'many', expected a whole number"),
        ("flips", {"trials": True}, "trials: got True, expected a whole number"),
        ("flips", {"trials": 0}, "trials: got 0, expected at least 1"),
        ("flips", {"max_steps": 0}, "max_steps: got 0, expected at least 1"),
        ("flips", {"seed": -1}, "seed: got -1, expected at least 0"),
        ("flips", {"shuffle": "x"}, "shuffle: got 'x', expected 'trial', 'study' or 'never'"),
        ("flips", {"p": [0.2, 0.2]}, "p: got [0.2, 0.2], expected at least one, and every one once"),
        ("flips", {"p": "all"}, "p: got 'all', expected a number"),
        ("flips", {"p": 1.5}, "p: got 1.5, expected a number from 0 to 1"),
        ("flips", {"plant": "twn"}, "no plant is called 'twn'"),
        ("flips", {"plant": "x" * 2000}, "plant: got 'xxxx"),
        ("flips", {"box": "chain-4,chain-44"}, "no box is called 'chain-44'"),
        ("flips", {"box": "chain-4,chain-4"}, "box: got ['chain-4', 'chain-4'], expected at least one, and every"),
        ("flips", {"box": []}, "box: got [], expected at least 1 item"),
        ("flips", {"box": "chain-4,fork", "until": "decided"}, "until: got 'decided', expected none with people or"),
        ("flips", {"box": "chain-4", "boxes": 3}, "boxes: got 3, expected none with the box chain-4, but with random-4"),
        ("flips", {"box": "random-3", "boxes": 3}, "boxes: got 3, expected none with the box random-3"),
        ("flips", {"boxes": 1}, "boxes: got 1, expected at least 2"),
        ("flips", {"agent": []}, "agents: got [], expected at least one"),
        ("flips", {"agent": 4}, "agent: got 4, expected a list"),
        ("flips", {"agent": ["a=random", "b=random"]}, "agents: got ['random', 'random'], expected at least one, and"),
        ("flips", {"agent": ["a=random", "a=round-robin"]}, "agents: got ['a', 'a'], expected at least one, and every"),
        ("flips", {"agent": "me=participant"}, "name of an agent: got {'participant': 'me'}, expected participant"),
        ("flips", {"agent": " =random"}, "agent: got ' =random', expected NAME=SPEC"),
        ("flips", {"agent": "a\x1b=random"}, r"name of an agent: got 'a\x1b', expected at most 200 visible characters"),
        ("flips", {"agent": f"human-inspired?lapse=0.{'1' * 200}"}, "name of an agent: got 'human-inspired?lapse"),
        ("flips", {"condition": "truth=nudge"}, "condition: got ['truth', 'truth'], expected at least one, and every one once"),
        ("flips", {"condition": "nudge + rgb", "plant": "fast-twin"}, "modality: got 'rgb', expected symbolic for random, which"),
        ("flips", {"sweep": "drop?p=0,1e-300"}, "a dose of drop?p=1e-300: got {'drop.p': 1e-300}, expected 0, or a"),
        ("flips", {"contrasts": {"a": {"of": "lie", "minus": "truth"}}}, "no condition of the contrast a is called 'lie'"),
        ("flips", {"contrasts": {"a": {"of": "truth", "minus": "truth"}}}, "condition of the contrast a: got ('truth', 'truth'), expected every one once, and on one side alone"),
        ("flips", {"contrasts": {"a": {"of": [], "minus": "truth"}}}, "contrasts: "),
        ("flips", {"contrasts": {"a": {"of": "truth"}}}, "contrasts.a.minus: is missing"),
        ("flips", {"flip": "afresh"}, "flip: got 'afresh', expected 'transient', 'sticky', 'outcome-only'"),
        ("modalities", {"flip": "sticky"}, "flip: got ['sticky'], expected a flip rate with it (--p)"),
        ("why", {"flip": "sticky,integrated"}, "flip: got ['sticky', 'integrated'], expected one, which all"),
        ("why", {"as_paper": True}, "as_paper: got True, expected none with why, but with flips, modalities"),
        ("why", {"full": True}, "full: got True, expected none with why, but with flips, modalities"),
        ("looks", {"until": "±10"}, "until: got '±10', expected none with looks, whose answer"),
        ("why", {"p": 0}, "condition: got 'lie', expected another condition than truth, which is the same"),
        ("why", {"p": "0.2,0.4"}, "p: got [0.2, 0.4], expected one, which all conditions"),
        ("why", PICTURED, "modality: got 'rgb', expected symbolic, with or without options: pictures cannot be"),
        ("why", {"modality": ["symbolic", "rgb"]}, "modality: got ['symbolic', 'rgb'], expected one, which all"),
        ("why", {"flip": "independent"}, "others: got 'noisy', expected one of fresh, kept"),
        ("why", {"condition": "flip?p=0.4&part=outcome"}, "part: got 'outcome', expected both with symbolic"),
        ("why", {"condition": "flip?p=0.4"}, "condition: got 'flip?p=0.4', expected another condition than lie"),
        ("why", {"condition": "warn + symbolic"}, "condition: got 'warn + symbolic', expected none that is shown"),
        ("looks", {"modality": ["rgb", "rgbd"]}, "modality: got ['rgb', 'rgbd'], expected one, which all conditions"),
        ("looks", {"plant": "fast-twin?discs=no"}, "plant: got 'fast-twin?discs=no', expected one without clutter"),
        ("looks", {"sweep": "plant.pose_error=0,1"}, "--sweep cannot be combined with looks: it has its own conditions"),
        ("looks", {"agent": "human-inspired"}, "modality: got 'rgb', expected symbolic for human-inspired, which"),
    ],
)  # fmt: skip
def test_what_has_no_meaning_is_one_line(name, asked, said):
    with pytest.raises(UserMistake) as refused:
        study(name, **({} if "agent" in asked or name in ("why", "looks") else {"agent": "random"}), **asked)
    assert str(refused.value).startswith(said)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("trails = 2", "no option is called 'trails' (did you mean 'trials'?)"),
        ('p = {a = "all"}', "p: got {'a': 'all'}, expected a number"),
        ("p = [", "not TOML"),
        ("# all of it is still to come\n", "says nothing to play: a study file has at least a line such as study"),
        ('name = "mine"', "says nothing to play"),
        ('flip = "often"', "flip: got 'often', expected 'transient', 'sticky', 'outcome-only'"),
        ("[box]\nname = 'mine'\n", "box: got {'name': 'mine'}, expected a text"),
        ('[[condition]]\nsepc = "nudge"\n', "condition.0.spec: is missing"),
        *((f'{key} = "python:os:getcwd"', f"{key}: python:os:getcwd would run code; name it on the command line")
          for key in ("agent", "condition", "sweep", "plant", "box")),
    ],
)  # fmt: skip
def test_what_is_wrong_in_a_study_file_is_named_and_none_runs_code(tmp_path, text, reason):
    path = tmp_path / "mine.toml"
    path.write_text(text)
    with pytest.raises(BadFile) as mistake:
        study(path)
    assert str(mistake.value).startswith(f"{path}: {reason}")


def test_what_is_named_beside_a_file_may_run_and_what_it_replaces_does_not_count(tmp_path):
    (tmp_path / "mine.toml").write_text('agent = ["python:os:getcwd", "random"]\n')
    for agent in ("python:os:getcwd", "round-robin"):
        assert study(tmp_path / "mine.toml", agent=agent).agents == (agent,)


def test_a_file_is_played_from_python_and_names_its_conditions(tmp_path):
    (tmp_path / "mine.toml").write_text(
        'name = "lab"\nagent = ["random"]\ntrials = 2\nrepetitions = 1\n'
        '[[condition]]\nname = "told the truth"\nspec = "truth"\n[[condition]]\nname = "lies"\nspec = "flip?p=0.4"\n'
    )
    planned = study(str(tmp_path / "mine.toml"))
    trials = lockprobe.run_study(planned, tmp_path / "d")
    assert trials == lockprobe.load(tmp_path / "d")
    assert [plan.key for plan in planned.plans("random")][:2] == [
        "lab/random/told the truth/rep=1/trial=1",
        "lab/random/lies/rep=1/trial=1",
    ]
    assert len(lockprobe.tidy(trials)) == sum(len(trial.steps) for trial in trials)
    assert set(lockprobe.__all__) <= set(dir(lockprobe)) | set(lockprobe._HOMES)
    with pytest.raises(AttributeError, match="module 'lockprobe' has no attribute 'bxo'"):
        _ = lockprobe.bxo


def test_a_condition_is_played_in_every_modality_unless_it_says_its_own():
    asked = {"modality": ["symbolic?tell=state", "rgb"], "condition": ["nudge", "warn + rgbd", "rgb?blur=8"]}
    assert labels(study("modalities", agent="viewer", **asked)) == [
        "truth", "nudge", "rgb", "nudge + rgb", "rgbd", "warn + rgbd", "rgb?blur=8",
    ]  # fmt: skip


def test_several_boxes_are_named_drawn_or_those_of_people():
    one = study("flips", box="fork", agent="random")
    assert (one.repetitions, one.trials, one.strategy_trials) == (3, 1, 100)
    planned = study("flips", boxes=6, agent="random", p=[0, 0.4])
    assert [optimum(one) for one in planned.boxes] == [4] * 6
    assert (planned.repetitions, planned.trials, planned.strategy_trials) == (1, 30, 120)
    assert planned.boxes == study("flips", boxes=9, agent="random").boxes[:6]
    assert {optimum(one) for one in study("why", box="random-5", boxes=3).boxes} == {5}
    assert [one.name for one in study("flips", box="chain-4, fork", agent="random").boxes] == ["chain-4", "fork"]
    people = study("flips", agent=["participant", "random"], p=[0, 0.4])
    assert (people.layout, [one.name for one in people.boxes]) == ("shuffled", list(ALIKE))


@pytest.mark.parametrize(
    ("layout", "asked"),
    [
        ("shuffled", {"agent": "participant", "box": "fork"}),
        ("shuffled", {"agent": "random", "modality": ["symbolic?places=yes"]}),
        ("shuffled", {"agent": "viewer", **PICTURED}),
        ("fixed", {"agent": "random"}),
        ("fixed", {"study": "modalities", "agent": "random", "plant": "manual"}),
        ("fixed", {"agent": "participant", "layout": "fixed", "box": "chain-4"}),
    ],
)
def test_who_sees_places_learns_nothing_from_them(layout, asked):
    assert study(asked.get("study", "flips"), **asked).layout == layout


def test_labels_are_drawn_in_every_trial_but_those_that_are_painted_on_a_real_box():
    plants = ("fast-twin", "manual", "manual?camera=0")
    assert [study("modalities", agent="viewer", plant=one).shuffle for one in plants] == ["trial", "trial", "never"]


def test_a_box_is_a_name_a_path_or_an_object_that_a_directory_can_hold(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(toml_of(box("fork")), "utf-8")
    same = ("fork", box("fork"), path, str(path))
    assert {study(box=one, **TINY).identity for one in same} == {study("flips", box="fork", **TINY).identity}
    assert [lockprobe.box(one) for one in same] == [box("fork")] * 4
    assert {lockprobe.propagate("human-inspired", one).solved[-1] for one in same} == {1.0}
    mine = replace(box("fork"), name="mine")
    first = run_study(study(box=mine, **TINY), tmp_path / "d")
    assert first == run_study(study(box=mine, **TINY), tmp_path / "d") == load(tmp_path / "d")
    assert ({trial.box for trial in first}, read_study(tmp_path / "d").box) == ({"mine"}, mine)
    with pytest.raises(UserMistake, match=r"other settings \(box is 'mine' there, 'another mine' asked"):
        run_study(study(box=replace(mine, target=mine.names[1]), **TINY), tmp_path / "d")
    locked = {name: ({"b": True},) for name in "t"} | {"b": ({"t": True},)}
    joints = tuple(lockprobe.Joint(name=name, kind="prismatic") for name in "tb")
    two = lockprobe.Lockbox(name="two", joints=joints, interlock={}, initial=(False, False), target="t")
    for bad, why in (
        ({"name": "my box"}, "that a file can hold .*name: got 'my box', expected a name"),
        ({"interlock": locked}, "can be played .unsolvable"),
    ):
        with pytest.raises(BadValue, match=f"^box: got .*{why}"):
            study(box=replace(two, **bad), **TINY)


# -- readings of a false report --

MODEL, STRATEGY = "llm:local", "random"
FULL = preset("flips")
SHORT = FULL.when["short"]


def test_words_name_readings_and_several_are_played_side_by_side():
    asked = ("integrated", "sticky", "re-observed,integrated,memoryless,latched")
    planned = [study("flips", agent=STRATEGY, p="0,0.4", flip=words) for words in asked]
    assert [one.conditions[1].label for one in planned] == [
        "flip?p=0.4&others=kept", "flip?p=0.4&inverts=position&others=kept", "flip?p=0.4",
    ]  # fmt: skip
    assert [interventions_in(one)[0].reading for one in planned[2].conditions[1:]] == [
        "re-observed outcome noise", "integrated outcome noise", "memoryless state noise", "latched state noise",
    ]  # fmt: skip
    beside = study("flips", agent=STRATEGY, flip="integrated", condition="nudge")
    assert labels(beside) == ["truth", *(f"flip?p={p:g}&others=kept" for p in FULL.p if p), "nudge"]


def test_the_short_study_and_the_papers_play_lies_that_stay_where_that_costs_nothing():
    short, full = (study("flips", agent=[MODEL, STRATEGY], full=whole) for whole in (False, True))
    rates = [f"flip?p={p:g}" for p in SHORT.p if p]
    assert labels(short, MODEL) == ["truth", "flip?p=0.4"]
    assert labels(short, STRATEGY) == ["truth", *rates, *(f"{one}&others=kept" for one in rates), "no-feedback"]
    assert short.size_of(MODEL) == 2 * FULL.repetitions * SHORT.trials
    assert labels(study("flips", agent=MODEL), MODEL) == ["truth", *rates]  # which nobody else would play
    assert len(labels(full, STRATEGY)) == 2 * len(FULL.p) - 1
    assert labels(full, MODEL) == labels(full)[: len(FULL.p)]


THERE = study("flips", agent="cognitive:perseverant", p=[0, 0.4], trials=6, repetitions=1)


def like(there, **more):
    """A study with the rates of another one."""
    asked = {"agent": "human-inspired", "condition": f"flip?like={there}/flip?p=0.4", "trials": 4, "repetitions": 1}
    return study("flips", **asked | more)


def test_misreadings_of_another_study_are_a_condition_of_this_one(tmp_path):
    """The rates stand in the settings, so the other study may go; no path stands in a key."""
    run_study(THERE, tmp_path / "there")
    here = like(tmp_path / "there")
    said = claim_counts(trial for trial in load(tmp_path / "there") if trial.condition == "flip?p=0.4")
    matrix = misread_rates(said, THERE.box.names)
    rmtree(tmp_path / "there")
    trials = run_study(here, tmp_path / "here")
    condition = here.conditions[1]
    assert rates_of(condition.interventions[0].rates) == {
        joint: pytest.approx(rates, abs=1e-5) for joint, rates in matrix.items()
    }
    assert condition.interventions[0].size == said.total() > 20
    assert condition.label == "flip?p=1&like=flips/flip?p=0.4"
    assert str(tmp_path) not in json.dumps(here.settings())
    told = [trial for trial in trials if trial.condition == condition.label]
    assert any(step.told_falsely for trial in told for step in trial.steps)
    for trial in told:
        labelled = dict(zip(trial.labels, trial.joints, strict=True))
        for label, rates in rates_of(tuple(str(trial.channels[0]["by_label"]).split(";"))).items():
            assert rates == pytest.approx(matrix[labelled[label]], abs=1e-5)
    assert read_study(tmp_path / "here").identity == here.identity
    assert [check.name for check in verify(tmp_path / "here") if not check.holds] == []


def test_a_source_that_does_not_fit_is_refused_before_anything_is_played(tmp_path):
    run_study(THERE, tmp_path / "there")
    run_study(replace(THERE, name="silent", assessment=False), tmp_path / "silent")
    for given, said in (
        ({"box": "chain-3"}, "expected a study of chain-3, not of chain-4"),
        ({"condition": f"flip?like={tmp_path}/there/rgb"}, "no condition in .* is called 'rgb'"),
        ({"condition": f"flip?like={tmp_path}/silent/truth"}, "whose agent said what its attempts did"),
        ({"condition": f"flip?like={tmp_path}/there/truth&of=random"}, "of: got 'random', expected an agent of"),
        ({"condition": "flip?like=truth"}, "DIR/CONDITION, with the directory of a finished study"),
        ({"condition": "flip?like=nowhere/truth"}, "no study.json here"),
    ):
        with pytest.raises(UserMistake, match=said):
            like(tmp_path / "there", **given)
    other = like(tmp_path / "there", box="chain-3", condition=f"flip?like={tmp_path}/there/flip?p=0.4&by=total")
    rates = rates_of(other.conditions[1].interventions[0].rates)
    assert set(rates) == set(other.box.names)
    assert len({*rates.values()}) == 1


# -- studies with conditions of their own --


def test_why_plays_every_arm_at_the_papers_rate_and_other_conditions_after_them():
    planned = study("why")
    assert (planned.name, planned.agents[0], planned.repetitions) == ("why", "cognitive:insistent", 1)
    assert [one.spec for one in planned.conditions] == [spec.format(p="0.4", reading="") for spec in ARMS.values()]
    more = study("why", p=0.2, condition="flip?p=0.2&while=looping", agent="random", trials=2)
    assert labels(more) == [*ARMS, "flip?p=0.2&while=looping"]
    assert more.conditions[1].specs == ("flip?p=0.2",)


@pytest.mark.parametrize("flip", ["re-observed", "integrated", "memoryless", "latched", "outcome-only"])
def test_every_arm_hits_the_same_steps_with_lies_of_the_kind_that_is_asked_for(flip):
    """A blind agent acts alike in every arm; so what is told last is equal where the last statement is a lie."""
    planned = study("why", flip=flip, agent="round-robin")
    arms = {
        one.label: run_trial(agent="round-robin", condition=one, trial=2, box="chain-5").steps
        for one in planned.conditions
    }
    told = {arm: [(step.told_moved, step.told_state) for step in steps] for arm, steps in arms.items()}
    assert told["truth-lie"] == told["lie-lie"] == told["lie"] != told["truth"]
    assert told["truth-truth"] == told["lie-truth"] == told["remark"] == told["truth"]
    if flip == "re-observed":
        lies = [step.told_falsely for step in arms["lie"]]
        assert 3 < sum(lies) < 17
        for arm in CROSSED:
            assert ["Correction:" in step.told for step in arms[arm]] == lies
            assert any(step.told_falsely for step in arms[arm]) == arm.endswith("lie")
        first, last = (
            [part.strip() for part in arms[arm][lies.index(True)].told.split("Correction:")]
            for arm in ("lie-truth", "truth-lie")
        )
        assert first == last[::-1] != last
        assert [bool(step.remark) for step in arms["remark"][1:]] == lies[:-1]


FACTORS = {
    "discs": "no", "handle_colours": "plain", "labels": "no", "clutter": "8", "light": "side", "colours": "second",
    "viewpoint": "oblique", "view_jitter": "5",
}  # fmt: skip


def test_scenes_of_looks_are_a_factorial_design_of_all_factors_and_each_has_its_contrast():
    """No factor is mixed with another, or with an interaction of two (resolution IV)."""
    found = study("looks")
    signs = np.array([[1 if name in one.plant.options else -1 for name in FACTORS] for one in found.conditions])
    assert (signs.shape, len({*map(tuple, signs)}), {*signs[0]}) == ((16, 8), 16, {-1})
    pairs = [first * second for first, second in combinations(signs.T, 2)]
    for column in signs.T:
        assert column.sum() == 0
        assert not any(column @ pair for pair in pairs)
    assert [*found.contrasts] == [f"{name}={high}" for name, high in FACTORS.items()]
    for column, one in zip(signs.T, found.contrasts.values(), strict=True):
        named = {label for label, sign in zip(labels(found), column, strict=True) if sign > 0}
        assert (one.measure, {*one.of}, len(one.minus)) == ("misreading", named, 8)
    assert len(found.conditions) == len(found.plants) == 16
    assert (found.conditions[0].label, found.plant_of(found.conditions[0])) == ("plain scene", "fast-twin")
    assert (found.layout, found.trials, found.repetitions) == ("shuffled", 10, 1)


@pytest.mark.parametrize("name", SHIPPED)
def test_what_ships_is_a_study(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = study(name)
    assert found.p == tuple(round(0.1 * i, 1) for i in range(11))
    assert found.repetitions * found.trials >= 300


# -- as in the paper --


FIRST = """\
You are trying to open a lockbox, a panel with 4 joints.
Every joint has two positions, 0 and 1. The joints lock each other in a hidden way: whether a joint can move depends on \
the positions of other joints. If you attempt a joint that is not locked, it moves to its other position; if it is \
locked, nothing happens.
The box is open as soon as the target joint moves. You have 4 steps. In every step you choose one joint to attempt. \
Then you are told the position of every joint. You are not told whether a joint moved: find out by comparing \
successive reports.
Reply with one JSON object and nothing else:
{"last_action": "moved" or "did not move" ("none" in the first step), "joint": the joint to attempt next}
The panel's joints: C, D, B, A. The target joint: B.

{"positions": {"C": 0, "D": 0, "B": 0, "A": 0}}"""


def test_as_paper_a_hosted_model_is_sent_these_messages(tmp_path):
    """Labels and states of all joints after every step, no outcome, no hypothesis, and the last action assessed."""
    chosen = iter("CADC")

    with here(lambda request: replying(request, next(chosen))) as server:
        asked = {"as_paper": True, "p": [0], "trials": 1, "repetitions": 1, "max_steps": 4}  # what is given wins
        found = study("flips", agent="llm:openai-api/fake/model", **asked)
        limits = Limits(access=Access(connections=1))
        run_study(found, tmp_path / "study", limits=limits)
    sent = server.requests[-1]
    assert [(one["role"], words(one)) for one in sent["messages"]] == [
        ("user", FIRST),
        ("assistant", '{"last_action": "none", "joint": "C"}'),
        ("user", '{"attempted": "C", "positions": {"C": 0, "D": 0, "B": 0, "A": 0}}'),
        ("assistant", '{"last_action": "moved", "joint": "A"}'),
        ("user", '{"attempted": "A", "positions": {"C": 0, "D": 0, "B": 0, "A": 1}}'),
        ("assistant", '{"last_action": "moved", "joint": "D"}'),
        ("user", '{"attempted": "D", "positions": {"C": 0, "D": 1, "B": 0, "A": 1}}'),
    ]
    form = sent["response_format"]["json_schema"]["schema"]
    assert form["properties"] == {
        "last_action": {"type": "string", "enum": ["moved", "did not move"]},
        "joint": {"type": "string", "enum": ["C", "D", "B", "A"]},
    }
    assert form["required"] == ["last_action", "joint"]
    assert [check for check in verify(tmp_path / "study") if not check.holds] == []


# -- a trial alone --

OF_TRIALS = {"repetition", "trial", "pictures"}
OF_STUDIES = {
    "study", "trials", "strategy_trials", "repetitions", "full", "as_paper", "name", "sweep",
    "until", "boxes", "contrasts",
}  # fmt: skip


def test_a_trial_has_the_options_of_a_study_and_its_own_place_in_it():
    assert inspect.signature(run_trial).parameters.keys() == (StudyOptions.model_fields.keys() - OF_STUDIES) | OF_TRIALS


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
    rates = {} if "condition" in asked else {"p": [asked.get("p", 0.0)]}
    planned = study("flips", agent="human-inspired", trials=3, repetitions=2, **(asked | rates))
    plan = planned.plan("human-inspired", planned.conditions[-1], 2, 3)
    alone = trial_study("human-inspired", **asked, trial=3, repetition=2)
    assert len(alone.conditions) == 1
    assert replace(plan, study="trial") == alone.plan("human-inspired", alone.conditions[0], 2, 3)


def test_a_condition_is_a_spec_an_object_or_a_list():
    tremble = Tremble(p=0.2)
    asked = ("tremble?p=0.2", Condition(interventions=(tremble,)), (tremble,), [tremble])
    assert len({run_trial(condition=one).key for one in asked}) == 1
    assert len({run_trial(condition=one).key for one in (None, "", (), "truth", Condition())}) == 1


@pytest.mark.parametrize(
    ("asked", "kind", "message"),
    [
        ({"trails": 3}, TypeError, "run_trial() got an unexpected keyword argument 'trails'"),
        ({"repetition": "x"}, BadValue, "repetitions: got 'x', expected a whole number"),
        ({"trial": 0}, BadValue, "trials: got 0, expected at least 1"),
        ({"p": [0.1, 0.2]}, BadValue, "p: got [0.1, 0.2], expected one for one trial"),
        ({"box": 4}, BadValue, "box: got 4, expected a text"),
        ({"agent": ""}, BadValue, "agents: got ('',), expected at least 1 character"),
        ({"agent": 4}, BadValue, "agent: got 4, expected an agent spec, or an object with facts and decide()"),
        ({"flip": "sticky", "condition": "nudge"}, BadValue, "flip: got 'sticky', expected a flip rate p with it"),
        ({"condition": [4]}, BadValue, "condition: got [4], expected specs with plus signs, a Condition, or"),
        ({"condition": "rgb", "modality": "rgbd"}, BadValue, "modality: got ['rgbd'], expected none with a condition"),
        ({"box": "nowhere"}, UnknownName, "no box is called 'nowhere'"),
    ],
)
def test_what_a_trial_cannot_be_asked_is_one_line(asked, kind, message):
    with pytest.raises(kind) as mistake:
        run_trial(**asked)
    assert str(mistake.value).startswith(message)
    assert "\n" not in str(mistake.value)


OWN = """
from lockprobe import Decision
class First:
    facts = {}
    async def decide(self, situation, rng):
        return Decision(joint=situation.task.joints[%s])
"""


@pytest.fixture
def written(tmp_path, monkeypatch):
    """A class of one's own in a module, which chooses this joint."""
    monkeypatch.syspath_prepend(tmp_path)

    def write(joint):
        sys.modules.pop("my_own", None)
        (tmp_path / "my_own.py").write_text(OWN % joint, "utf-8")
        invalidate_caches()
        return import_module("my_own").First

    return write


def test_an_agent_is_also_a_class_as_in_a_notebook(written):
    first, asked = written(0), {"p": [0], "trials": 1}
    assert study(agent=[first, "random"], **asked).agents == ("python:my_own:First", "random")
    assert study(agent=first, **asked) == study(agent="python:my_own:First", **asked)
    assert study(agent={"mine": first, "r": "random"}, **asked).labels == ("mine", "r")
    one, same = (run_trial(agent=agent, seed=1) for agent in (first, first()))
    assert (one.actions, one.ending) == (same.actions, same.ending) != ((), "error")


def test_a_class_that_was_changed_does_not_play_on_where_it_began(tmp_path, written):
    def play(joint, trials):
        return run_study(study(agent=written(joint), p=[0], trials=trials, repetitions=1), tmp_path / "d")

    assert [len(play("0", trials)) for trials in (1, 2)] == [1, 2]
    with pytest.raises(SettingsChanged, match="python:my_own:First, source is '.*' there, '.*' asked"):
        play("1", 3)
