"""One box that is looked at: pictures instead of reports, and the very pictures that a study keeps."""

import copy
import pickle
from dataclasses import dataclass, replace
from typing import ClassVar

import gymnasium
import numpy as np
import pytest
from gymnasium import spaces
from gymnasium.utils.env_checker import check_env
from painted import painted_twins

from lockprobe import run_trial
from lockprobe.foundation.errors import BadValue, ChannelFault, PlantFault
from lockprobe.interfaces.gymnasium.single import LockboxEnv
from lockprobe.trial.pictures.png import from_png, to_png
from lockprobe.trial.record import Decision

SMALL = "fast-twin?width=80&height=64"
SOLUTION = (3, 2, 1, 0)


@pytest.fixture(autouse=True)
def made(monkeypatch):
    return painted_twins(monkeypatch)


def looking(observation="rgb", **asked):
    return LockboxEnv(**{"observation": observation, "plant": SMALL} | asked)


def seen(env, actions, **asked):
    """All pictures of an episode."""
    pictures = [env.reset(**asked)[0]]
    pictures += [env.step(action)[0] for action in actions]
    return pictures


@pytest.mark.parametrize("observation", ["symbolic", "rgb", "rgbd"])
def test_gymnasium_finds_nothing_to_say_against_it(observation):
    check_env(gymnasium.make("lockprobe/Lockbox-v0", observation=observation, plant=SMALL, shuffle="trial").unwrapped)


def test_the_spaces_are_those_of_the_plants_pictures():
    assert looking().observation_space == spaces.Box(0, 255, (64, 80, 3), np.uint8)
    space = looking("rgbd", plant="fast-twin?width=100&height=70").observation_space
    assert space["rgb"] == spaces.Box(0, 255, (70, 100, 3), np.uint8)
    assert space["depth"] == spaces.Box(0.0, 4.0, (70, 100, 1), np.float32)
    assert LockboxEnv(observation="rgb", plant="twin").observation_space.shape == (480, 640, 3)


def test_depth_is_in_metres_and_zero_where_there_is_none():
    picture, _ = looking("rgbd").reset(seed=1)
    assert picture["depth"].dtype == np.float32
    assert np.unique(picture["depth"]).tolist() == pytest.approx([0, 0.65, 0.7])
    assert picture["depth"][0].max() == 0  # nothing was there
    assert picture["depth"][1].max() == 0  # it was farther away than the space says
    assert (picture["rgb"] == looking().reset(seed=1)[0]).all()


class Shuffled:
    facts: ClassVar = {}

    async def decide(self, situation, rng):
        return Decision(joint=situation.task.joints[int(rng.integers(4))])


FALSE = [
    {"modality": "rgb?p=0.4"},
    {"modality": "rgbd?depth=height", "p": 0.5, "flip": "sticky"},
    {"observation": "rgb", "condition": "flip?p=0.4&keep=0.5"},
]
SHOWN = [
    *FALSE,
    {"observation": "rgbd"},
    {"modality": "rgb?blur=2&noise=0.1&occlude=0.2&exposure=-1"},
    {"condition": "tremble?p=0.3 + rgbd", "layout": "shuffled"},
]


@pytest.mark.parametrize("asked", SHOWN)
def test_false_and_damaged_pictures_pass_gymnasiums_check(asked):
    env = LockboxEnv(plant=SMALL, **asked)
    check_env(env, skip_render_check=True)
    assert isinstance(env.observation_space, spaces.Dict) == ("rgbd" in str(asked))


@pytest.mark.parametrize("asked", SHOWN)
def test_true_false_and_damaged_pictures_and_the_record_are_those_of_the_trial(asked, tmp_path):
    words = {"modality" if name == "observation" else name: value for name, value in asked.items()}
    there = run_trial(
        agent=Shuffled(), plant=SMALL, seed=4, repetition=2, trial=3, max_steps=8, pictures=tmp_path, **words
    )
    env = LockboxEnv(plant=SMALL, shuffle="trial", max_steps=8, **asked)
    actions = [there.listing.index(step.decision.joint) for step in there.steps]
    shown = seen(env, actions, seed=4, options={"repetition": 2, "trial": 3})
    names = [there.opening_pictures, *(step.pictures for step in there.steps)]
    for picture, kept in zip(shown, names, strict=True):
        rgb = picture["rgb"] if isinstance(picture, dict) else picture
        assert (rgb == from_png((tmp_path / kept["rgb"]).read_bytes())).all()
        if isinstance(picture, dict):
            metres = from_png((tmp_path / kept["depth16"]).read_bytes()) / np.float32(1000)
            assert (picture["depth"][..., 0] == np.where(metres <= 4, metres, 0)).all()
    here = env.trial
    assert replace(here, key=there.key, study=there.study, agent=there.agent, steps=()) == replace(there, steps=())
    assert [replace(step, decision=None) for step in here.steps] == [
        replace(step, decision=None) for step in there.steps
    ]
    assert any(step.told_falsely for step in there.steps) == (asked in FALSE)


def test_an_observation_holds_nothing_but_what_is_seen(monkeypatch):
    told = [looking(info="truth", shuffle="trial").reset(seed=2)]
    assert sorted(told[0][1]) == ["labels", "target", "truth"]
    picture, info = looking(shuffle="trial").reset(seed=2)
    assert (picture == told[0][0]).all()
    assert sorted(info) == ["labels", "target"]
    env = looking(shuffle="trial")
    env.reset(seed=2)
    task = env._episode.heard.task
    assert (info["labels"][info["target"]], info["labels"]) == (task.target, "".join(task.joints))
    percept = env._episode.heard.percept
    assert (percept.outcome, percept.positions, percept.look) == (None, None, percept.look)


def test_the_same_seed_shows_the_same_and_a_reset_goes_on():
    env = looking()
    first, second = (seen(env, SOLUTION[:2], **asked) for asked in ({"seed": 3}, {}))
    assert (np.array(first) == np.array(seen(looking(), SOLUTION[:2], seed=3))).all()
    assert (np.array(second) == np.array(seen(looking(), SOLUTION[:2], seed=3, options={"trial": 2}))).all()
    assert (np.array(first) != np.array(second)).any()


def test_every_plant_is_let_go_of_once(made):
    env = looking()
    env.close()
    assert made == []  # nothing is opened before it is needed
    for _ in range(3):
        seen(env, SOLUTION)
    env.close()
    env.close()
    assert [plant.closed for plant in made] == [1, 1, 1]
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(0)


def test_it_is_looked_at_once_a_step_and_not_at_all_without_need(made):
    env = looking("rgbd", render_mode="rgb_array")
    env.reset(seed=1)
    env.step(0)
    env.render()
    env.render()
    env.close()
    seen(LockboxEnv(plant=SMALL), SOLUTION)
    assert [plant.looks for plant in made] == [2, 0]


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_a_copy_goes_on_as_the_original_does(copied):
    env = looking("rgbd")
    env.reset(seed=2)
    env.step(3)
    other = copied(env)
    for joint in (2, 0, 1):
        here, there = env.step(joint), other.step(joint)
        assert (here[0]["rgb"] == there[0]["rgb"]).all()
        assert here[1:] == there[1:]


@pytest.mark.parametrize("observation", ["symbolic", "rgb"])
def test_it_is_rendered_whatever_the_observation_is(observation):
    pictures = looking().reset(seed=1)[0]
    env = looking(observation, render_mode="rgb_array")
    assert env.render() is None
    env.reset(seed=1)
    assert (env.render() == pictures).all()
    for joint in SOLUTION:
        env.step(joint)
    assert (env.render() != pictures).any()  # also after the last step
    deep = looking(observation, render_mode="depth_array")
    deep.reset(seed=1)
    assert deep.render().shape == (64, 80)
    words = looking(render_mode="ansi")
    words.reset(seed=1)
    words.step(1)
    assert words.render().startswith("Joints: 0 A, 1 B, 2 C, 3 D. Target: A. Steps left: 19.\n")
    assert "moved" not in words.render()
    assert "did not" not in words.render()


def test_what_can_be_rendered_is_said():
    assert LockboxEnv().metadata["render_modes"] == ["ansi"]
    assert looking().metadata["render_modes"] == ["ansi", "rgb_array", "depth_array"]
    blind = gymnasium.make("lockprobe/Lockbox-v0", render_mode="rgb_array")  # tools ask every environment for pictures
    blind.reset(seed=1)
    with pytest.raises(BadValue, match="^render_mode: got 'rgb_array', expected ansi, or plant='fast-twin' or 'twin'"):
        blind.unwrapped.render()


@dataclass(frozen=True)
class Dimmed:
    """Makes pictures dark on their way."""

    after_words = always_tells = True

    def perceive(self, percept, past, task, rng):
        dark = tuple(replace(picture, png=to_png(from_png(picture.png) // 2)) for picture in percept.pictures)
        return replace(percept, pictures=dark)


@dataclass(frozen=True)
class Blindfold:
    after_words = always_tells = True

    def perceive(self, percept, past, task, rng):
        return replace(percept, pictures=())


def test_what_acts_after_the_camera_acts_on_what_is_seen():
    bright = looking().reset(seed=1)[0]
    assert (looking(condition=[Dimmed()]).reset(seed=1)[0] == bright // 2).all()
    with pytest.raises(ChannelFault, match="no picture of the kind rgb reached the agent"):
        looking(condition=[Blindfold()]).reset(seed=1)


def test_a_plant_that_breaks_is_no_failure_to_solve(monkeypatch):
    def broken(*given):
        raise RuntimeError("no power")

    painted_twins(monkeypatch, broken)
    with pytest.raises(PlantFault, match="RuntimeError: no power"):
        looking().reset(seed=1)
