"""The plant of an episode: made with the trial's own stream, looked at once, and never across a fork."""

import os

import numpy as np
import pytest
from painted import painted_twins

from lockprobe.environment import plant as module
from lockprobe.environment.plant import WatchedPlant, make_plant
from lockprobe.environment.settings import read_settings
from lockprobe.errors import BadValue, PlantFault
from lockprobe.lockbox.families import box
from lockprobe.plan import Names
from lockprobe.plants.symbolic import SymbolicPlant


@pytest.fixture
def made(monkeypatch):
    return painted_twins(monkeypatch)


def watched(seed=1):
    plan = read_settings({"plant": "fast-twin", "shuffle": True}).plan(seed, 1, 1)
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
    with pytest.raises(PlantFault, match="forked: call reset"):
        plant.attempt(0)
    plant.close()
    assert (made[0].closed, kept) == (0, made)


def test_in_a_fork_of_a_process_with_opengl_it_lives_elsewhere(monkeypatch):
    asked = []
    monkeypatch.setattr(module, "must_live_elsewhere", lambda: True)
    monkeypatch.setattr(module, "PlantElsewhere", lambda *given: asked.append(given))
    plan = read_settings({"plant": "fast-twin?width=64", "shuffle": True}).plan(1, 1, 1)
    make_plant(plan, Names(plan))
    spec, puzzle, labels, rng = asked[0]
    assert (spec, puzzle, labels) == ("fast-twin?width=64", plan.box, Names(plan).labels)
    assert rng.random() == plan.stream("plant").random()
    symbolic = read_settings({}).plan(1, 1, 1)
    assert isinstance(make_plant(symbolic, Names(symbolic)), SymbolicPlant)  # which has no camera
    assert isinstance(rng, np.random.Generator)
