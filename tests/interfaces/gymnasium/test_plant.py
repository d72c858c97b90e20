"""The plant of an episode: made with the trial's own stream, looked at once, and never across a fork."""

import os
from itertools import pairwise

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from painted import painted_twins

from lockprobe import run_trial
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadValue, PlantFault
from lockprobe.interfaces.gymnasium import plant as module
from lockprobe.interfaces.gymnasium.plant import WatchedPlant, make_plant
from lockprobe.interfaces.gymnasium.settings import read_settings
from lockprobe.interfaces.gymnasium.single import LockboxEnv
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.testing import ScriptedAgent
from lockprobe.trial.pictures.png import from_png
from lockprobe.trial.plan import Names

SMALL = "fast-twin?width=64&height=64&looks=varied&depth_noise=0.001"


@pytest.fixture
def made(monkeypatch):
    return painted_twins(monkeypatch)


def watched(seed=1):
    plan = read_settings({"plant": "fast-twin", "shuffle": "trial"}).plan(seed, 1, 1)
    return WatchedPlant(lambda: make_plant(plan, Names(plan)))


def test_it_is_made_when_it_is_first_observed_and_closed_once(made):
    plant = watched()
    plant.close()
    assert plant.facts == {}
    assert made == []
    plant.observe()
    assert plant.facts == {"engine": "paint"}
    plant.close()
    plant.close()
    assert [one.closed for one in made] == [1]


def test_a_moment_has_one_picture(made):
    plant = watched()
    snapshot = plant.observe()
    assert plant.frame() is snapshot.look() is plant.frame()
    before, now = plant.frame(), plant.attempt(3)
    assert plant.configuration == now.configuration == (False, False, False, True)
    assert (plant.frame().rgb != before.rgb).any()
    assert made[0].looks == 2


def test_the_trials_stream_decides_how_it_looks(made):
    pictures = []
    for seed in (1, 1, 2):
        plant = watched(seed)
        plant.observe()
        pictures.append(plant.frame().rgb)
    assert (pictures[0] == pictures[1]).all()
    assert (pictures[0] != pictures[2]).any()


def test_what_cannot_be_looked_at_says_so():
    plant = WatchedPlant(lambda: SymbolicPlant(box("chain-4")))
    plant.observe()
    with pytest.raises(BadValue, match="SymbolicPlant"):
        plant.frame()


def test_a_forked_process_leaves_the_plant_of_its_parent_alone(made, monkeypatch):
    plant = watched()
    plant.observe()
    monkeypatch.setattr(module, "_ABANDONED", kept := [])
    monkeypatch.setattr(os, "getpid", lambda: -1)
    with pytest.raises(PlantFault, match="parent process: call reset"):
        plant.attempt(0)
    plant.close()
    assert (made[0].closed, kept) == (0, made)


@pytest.mark.slow
def test_gymnasium_finds_nothing_to_say_against_the_physical_box():
    check_env(gymnasium.make("lockprobe/Lockbox-v0", observation="rgbd", plant=SMALL).unwrapped, skip_render_check=True)


def test_an_episode_with_the_physical_box_shows_the_pictures_of_the_study(tmp_path):
    trial = run_trial(
        agent=ScriptedAgent(joints=(3, 2, 1, 0)),
        plant=SMALL,
        modality="rgbd",
        seed=5,
        trial=3,
        shuffle="never",
        pictures=tmp_path,
    )
    assert trial.solved
    env = LockboxEnv(observation="rgbd", plant=SMALL, render_mode="rgb_array")
    here = [env.reset(seed=5, options={"trial": 3})[0], *(env.step(joint)[0] for joint in (3, 2, 1, 0))]
    assert (env.render() == here[-1]["rgb"]).all()
    for seen, names in zip(here, (trial.opening_pictures, *(step.pictures for step in trial.steps)), strict=True):
        assert (seen["rgb"] == from_png((tmp_path / names["rgb"]).read_bytes())).all()
        millimetres = np.rint(seen["depth"][..., 0] * 1000).astype(int)
        assert (millimetres == from_png((tmp_path / names["depth16"]).read_bytes())).all()
    assert np.median(here[0]["depth"]) > 0.5
    assert [(one["rgb"] != other["rgb"]).any() for one, other in pairwise(here)] == [True] * 4
    assert env.trial.plant == trial.plant
    env.close()
