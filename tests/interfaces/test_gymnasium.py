"""The environment: Gymnasium's contract, one box and many, and the very trials that a study plays."""

import copy
import importlib
import pickle
import sys
from dataclasses import dataclass, replace
from itertools import cycle
from typing import get_args

import gymnasium
import numpy as np
import pytest
from gymnasium.envs import registration
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import check_env, data_equivalence
from gymnasium.vector import SyncVectorEnv
from hypothesis import given, settings
from hypothesis import strategies as st
from painted import painted_twins

import lockprobe
from lockprobe import run_trial
from lockprobe.boxes.box import Joint, LayoutKind, Lockbox, Shuffle
from lockprobe.foundation.errors import ChannelFault, PlantFault, UserMistake
from lockprobe.interfaces.gymnasium import ENVIRONMENT
from lockprobe.interfaces.gymnasium.environment import LockboxEnv
from lockprobe.interfaces.gymnasium.vector import LockboxVectorEnv
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.testing import ScriptedAgent
from lockprobe.trial.pictures.frame import from_png
from lockprobe.trial.trial_json import trial_from_json, trial_to_json

SMALL = "fast-twin?width=80&height=64"
COUNT = 4
FORK = Lockbox(
    name="fork",
    joints=tuple(Joint(name=name, kind="prismatic") for name in "tabc"),
    interlock={"t": ({"a": True}, {"b": False, "c": True}), "a": ({"b": True},), "b": ({"c": False},)},
    initial=(False, False, True, False),
    target="t",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Never(OutcomeFlip):
    """A flip of a package: it looks like one, and says the truth."""

    def perceive(self, percept, past, task, rng):
        return percept


PLAIN = [
    {},
    {"box": "chain-8", "condition": "flip?p=0.3&others=kept", "max_steps": 5},
    {"condition": "flip?p=0.4&inverts=position&others=noisy", "shuffle": "trial", "box": FORK},
    {"condition": "flip?p=0.3&keep=0.5", "layout": "shuffled"},
    {"modality": "symbolic?tell=state", "p": 0.4, "shuffle": "study", "layout": "dealt"},
    {"modality": "symbolic?tell=outcome", "p": 0.4, "flip": "sticky", "shuffle": "trial"},
    {"condition": "flip?p=0.4&part=outcome", "box": "chain-2"},
]
OTHERS = [
    {"condition": "flip?p=0.3&keep=0.5 + flip?p=0.4&inverts=position", "layout": "shuffled"},
    {"condition": "flip?p=0.4&only=moved"},
    {"modality": "symbolic?tell=outcome", "condition": "tremble?p=0.3 + flip?p=0.2&only=moved"},
    {"condition": "drop?p=0.5 + tremble?p=0.2"},
    {"condition": "tremble?p=1&at=2 + delay?lag=1", "p": 0.4, "max_steps": 9, "layout": "shuffled"},
    {"condition": [Never(p=0.4)]},
]


def settled(trial):
    """A record without what names the study, and without who chose."""
    steps = tuple(replace(step, decision=None) for step in trial.steps)
    return replace(trial, key="", study="", agent="", facts={}, steps=steps)


@pytest.mark.parametrize(("asked", "seed"), [*zip([*PLAIN, *OTHERS], cycle((1, 2**62)), strict=False)])
def test_an_episode_is_the_trial_of_the_study_and_gymnasium_has_nothing_to_say_against_it(asked, seed):
    """What is told, the reward, the ends and the record, under every condition; and nothing else is told."""
    check_env(gymnasium.make(ENVIRONMENT, **asked).unwrapped)
    defaults = {"modality": "symbolic", "shuffle": "never"}
    there = run_trial(agent="random", seed=seed, repetition=2, trial=7, **(defaults | asked))
    env = LockboxEnv(**asked)
    first, _ = env.reset(seed=seed, options={"repetition": 2, "trial": 7})
    assert first[:3].tolist() == [there.listing.index(there.labels[there.joints.index(there.target)]), 0, 0]
    for step in there.steps:
        action = there.listing.index(there.labels[there.joints.index(step.chosen or step.joint)])
        told, reward, terminated, truncated, info = env.step(action)
        outcome = 0 if step.told_moved is None or "tell=state" in str(asked) else 1 + step.told_moved
        assert told[2] == outcome
        if step.told_state is not None and len(told) > 4:
            at = dict(zip(there.listing, told[3:].tolist(), strict=False))
            assert "".join(str(at[label]) for label in there.labels) == step.told_state
        assert reward == terminated
        assert info == {}
    assert (terminated, truncated) == (there.ending == "solved", there.ending == "budget")
    assert settled(env.trial) == settled(there)
    assert trial_from_json(trial_to_json(env.trial)) == env.trial


def episode(env, actions, **asked):
    """Observations of one episode under these actions, until it ends."""
    told = [env.reset(**asked)[0].tolist()]
    for action in actions:
        seen, _, terminated, truncated, _ = env.step(action)
        told.append(seen.tolist())
        if terminated or truncated:
            break
    return told


def test_a_seed_fixes_everything_after_it_and_a_reset_goes_on():
    actions = np.random.default_rng(0).integers(4, size=20).tolist()
    env, other, unseeded = (LockboxEnv(p=0.5, shuffle="trial") for _ in range(3))
    first = [episode(env, actions, **asked) for asked in ({"seed": 7}, {}, {})]
    assert [episode(other, actions, **asked) for asked in ({"seed": 7}, {}, {})] == first
    assert episode(other, actions[:3], seed=7, options={"trial": 2}) == first[1][:4]  # not played to its end
    assert episode(other, actions) == first[2]
    assert len({str(one) for one in (*first, *(episode(unseeded, actions) for _ in range(2)))}) == 5


@pytest.mark.parametrize("condition", ["flip?p=0.5&others=kept", "flip?p=0.5 + drop?p=0.3"])
@pytest.mark.parametrize("copied", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_a_copy_goes_on_as_the_original_does(copied, condition):
    env = gymnasium.make(ENVIRONMENT, condition=condition, shuffle="trial", max_steps=9)
    env.reset(seed=2)
    for action in (0, 1, 2):
        env.step(action)
    twin = copied(env)
    rest = [0, 3, 1, 2, 3, 0]
    assert repr([twin.step(action) for action in rest]) == repr([env.step(action) for action in rest])
    assert twin.unwrapped.trial == env.unwrapped.trial


def made(mode=None, count=COUNT, **asked):
    return gymnasium.make_vec(ENVIRONMENT, num_envs=count, vectorization_mode=mode, **asked)


def equal(one, other):
    """Equal in every number, kind of number and key."""
    return all(data_equivalence(here, there, exact=True) for here, there in zip(one, other, strict=True))


@pytest.mark.parametrize("asked", PLAIN)
@given(
    seed=st.integers(0, 10_000),
    seeds=st.lists(st.none() | st.integers(0, 99), min_size=COUNT, max_size=COUNT),
    shuffle=st.sampled_from(get_args(Shuffle)),
    layout=st.sampled_from(get_args(LayoutKind)),
)
@settings(max_examples=2, deadline=None)
def test_many_boxes_play_as_so_many_single_environments(asked, seed, seeds, shuffle, layout):
    asked = {"shuffle": shuffle, "layout": layout, "max_steps": 7} | asked
    ours, sync = made(**asked), made("sync", **asked)
    assert (type(ours.unwrapped), type(sync.unwrapped)) == (LockboxVectorEnv, SyncVectorEnv)
    assert (ours.observation_space, ours.action_space) == (sync.observation_space, sync.action_space)
    rng, kept = np.random.default_rng(seed), []
    for given_ in ({"seed": seed}, {}, {"seed": seeds, "options": {"repetition": 2, "trial": 5}}):
        here = ours.reset(**copy.deepcopy(given_))
        assert equal(here, sync.reset(**copy.deepcopy(given_)))
        for _ in range(18):
            joints = rng.integers(ours.single_action_space.n, size=COUNT)
            kept.append((here[0], here[0].copy()))
            here = ours.step(joints.astype(np.uint8))
            assert equal(here, sync.step(joints))
            assert here[0] in ours.observation_space
    assert all((now == then).all() for now, then in kept)  # what was returned is not written to again


@dataclass(frozen=True)
class Blindfold:
    always_tells = True

    def perceive(self, percept, past, task, rng):
        if percept.joint is not None:
            raise ValueError("no light")
        return replace(percept, positions=None)


VECTOR = 'vectorization_mode="sync" plays all else'


@pytest.mark.parametrize(
    ("make", "asked", "message"),
    [
        (LockboxEnv, {"max_step": 3}, "no setting of the environment is called 'max_step' (did you mean 'max_steps'?"),
        (LockboxEnv, {"seed": 3}, "no setting of the environment is called 'seed'"),
        (LockboxEnv, {"modality": "rgb"}, "modality: got 'rgb', expected a plant with a camera, fast-twin or twin"),
        (LockboxEnv, {"condition": "nudge"}, "condition: got 'nudge', expected interventions on reports or actions"),
        (LockboxEnv, {"plant": "twins"}, "no plant is called 'twins' (did you mean 'twin'?)"),
        (LockboxEnv, {"box": "chain-99"}, "no box is called 'chain-99'"),
        (LockboxEnv, {"max_steps": 0}, "max_steps: got 0, expected at least 1"),
        (made, {"condition": [Never()]}, VECTOR),
        (made, {"condition": "flip?p=0.2&at=3"}, VECTOR),
        (made, {"plant": "fast-twin"}, VECTOR),
        (made, {"count": 0}, "num_envs: got 0, expected a whole number from 1"),
    ],
)
def test_what_cannot_be_played_is_refused_in_one_line(make, asked, message):
    with pytest.raises(UserMistake) as mistake:
        make(**asked)
    assert message in str(mistake.value)
    assert "\n" not in str(mistake.value)


def test_a_wrong_call_is_refused_in_one_line():
    env, many = LockboxEnv(), made()
    for made_, action in ((env, 0), (many, np.zeros(COUNT, dtype=int))):
        with pytest.raises(ResetNeeded):
            made_.step(action)
        for options, message in (
            ({"trail": 1}, "no option of reset is called 'trail' .did you mean 'trial'"),
            ({"trial": 0}, "trial: got 0, expected a whole number from 1"),
        ):
            with pytest.raises(UserMistake, match=message):
                made_.reset(options=options)
        made_.reset(seed=1)
    for action in (4, -1, 1.0, "A"):
        with pytest.raises(UserMistake, match="action: got .*, expected a whole number from 0 to 3"):
            env.step(action)
    for actions in (np.full(COUNT, 4), np.full(COUNT, -1), np.zeros(2, dtype=int), np.zeros(COUNT), 0):
        with pytest.raises(UserMistake, match=f"actions: got .*, expected {COUNT} whole numbers from 0 to 3"):
            many.step(actions)
    with pytest.raises(UserMistake, match="seed: got .*, expected a whole number, or 4 of them"):
        many.reset(seed=[1, 2])
    for joint in (3, 2, 1, 0):
        env.step(joint)
    with pytest.raises(ResetNeeded):
        env.step(0)


@pytest.fixture
def plants(monkeypatch):
    return painted_twins(monkeypatch)


SHOWN = [
    {"modality": "rgbd"},
    {"modality": "rgb", "p": 0.4},
    {"modality": "rgbd?blur=1", "p": 0.5, "flip": "sticky"},
    {"modality": "rgb?blur=2&noise=0.1&occlude=0.2&exposure=-1"},
    {"condition": "tremble?p=0.3 + rgbd", "layout": "shuffled"},
]


@pytest.mark.usefixtures("plants")
@pytest.mark.parametrize("asked", SHOWN)
def test_true_false_and_damaged_pictures_and_the_record_are_those_of_the_trial(asked, tmp_path):
    where, agent = {"repetition": 2, "trial": 3}, ScriptedAgent(joints=(1, 3, 0, 2, 1))
    there = run_trial(agent=agent, plant=SMALL, seed=4, max_steps=8, pictures=tmp_path, **where, **asked)
    env = LockboxEnv(plant=SMALL, shuffle="trial", max_steps=8, **asked)
    check_env(env, skip_render_check=True)
    actions = [there.listing.index(step.decision.joint) for step in there.steps]
    shown = [env.reset(seed=4, options=where)[0], *(env.step(action)[0] for action in actions)]
    for picture, names in zip(shown, (there.opening_pictures, *(step.pictures for step in there.steps)), strict=True):
        seen = picture if isinstance(picture, dict) else {"rgb": picture}
        assert (seen["rgb"] == from_png((tmp_path / names["rgb"]).read_bytes())).all()
        if "depth" in seen:
            metres = from_png((tmp_path / names["depth16"]).read_bytes()) / np.float32(1000)
            assert (seen["depth"][..., 0] == np.where(metres <= 4, metres, 0)).all()
    assert settled(env.trial) == settled(there)


def test_what_is_seen_holds_no_truth_and_is_looked_at_once_a_step(plants):
    env = LockboxEnv(modality="rgb", plant=SMALL, shuffle="trial")
    for seed in (2, 3):
        picture, info = env.reset(seed=seed)
        assert sorted(info) == ["labels", "target"]
        assert picture in env.observation_space
        env.step(0)
    env.close()
    env.close()
    blind = LockboxEnv(plant=SMALL)
    blind.reset(seed=1)
    blind.step(0)
    assert [(plant.looks, plant.closed) for plant in plants] == [(2, 1), (2, 1), (0, 0)]


@pytest.mark.usefixtures("plants")
def test_channels_and_plants_that_break_are_faults_and_no_failure_to_solve(monkeypatch):
    env = LockboxEnv(condition=[Blindfold()])
    env.reset(seed=1)
    with pytest.raises(ChannelFault, match="ValueError: no light"):
        env.step(0)
    with pytest.raises(ResetNeeded):
        env.step(0)
    with pytest.raises(ChannelFault, match="no picture of the kind rgb reached the agent"):
        LockboxEnv(modality="rgb", plant=SMALL, condition=[Blindfold()]).reset(seed=1)

    def broken(*given):
        raise RuntimeError("no power")

    painted_twins(monkeypatch, broken)
    with pytest.raises(PlantFault, match="RuntimeError: no power"):
        LockboxEnv(modality="rgb", plant=SMALL).reset(seed=1)


def test_it_is_there_once_the_package_is_imported(monkeypatch):
    monkeypatch.delitem(registration.registry, ENVIRONMENT)
    monkeypatch.delitem(sys.modules, "lockprobe.interfaces.gymnasium")
    importlib.reload(lockprobe)
    gymnasium.make(f"lockprobe:{ENVIRONMENT}").reset(seed=1)
