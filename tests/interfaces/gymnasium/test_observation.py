"""The vector of what is told is the same in a study."""

from typing import ClassVar, get_args

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lockprobe import run_trial
from lockprobe.boxes.box import Shuffle
from lockprobe.foundation.errors import ChannelFault
from lockprobe.interfaces.gymnasium.observation import (
    UNTOLD,
    colours,
    distances,
    images,
    sizes,
    vector,
)
from lockprobe.interfaces.gymnasium.single import LockboxEnv
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.pictures.png import to_png
from lockprobe.trial.record import Decision, Percept, Task

TASK = Task(joints=("B", "C", "A"), target="A", budget=5)
FIRST = Percept(positions=(False, False, True))
SECOND = Percept(joint="C", outcome="moved", positions=(False, True, True), text="C moved.")


def test_every_entry_says_one_thing():
    assert vector(TASK, FIRST, positions=True).tolist() == [2, 0, 0, 0, 0, 1]
    assert vector(TASK, SECOND, positions=True).tolist() == [2, 2, 2, 0, 1, 1]
    assert vector(TASK, SECOND, 4, positions=True).tolist() == [2, 2, 2, 0, 1, 1, 4]
    assert vector(TASK, Percept(joint="B", outcome="blocked"), positions=False).tolist() == [2, 1, 1]
    assert vector(TASK, Percept(joint="B"), positions=False).tolist() == [2, 1, 0]
    assert vector(TASK, Percept(joint="B"), positions=True).tolist() == [2, 1, 0, UNTOLD, UNTOLD, UNTOLD]


@given(joints=st.integers(2, 8), positions=st.booleans(), budget=st.none() | st.integers(1, 50))
def test_there_is_a_size_for_every_entry(joints, positions, budget):
    labels = tuple("ABCDEFGH"[:joints])
    task = Task(joints=labels, target=labels[-1], budget=budget or 20)
    percept = Percept(joint=labels[-1], outcome="moved", positions=(True,) * joints if positions else None)
    largest = np.array(sizes(joints, positions=positions, budget=budget)) - 1
    assert vector(task, percept, budget, positions=positions).tolist() == largest.tolist()


CONDITIONS = [
    {"condition": "drop?p=0.4"},
    {"condition": "delay?lag=2 + tremble?p=0.3"},
    {"modality": "symbolic?tell=state", "p": 0.4},
    {"modality": "symbolic?tell=outcome", "p": 0.4, "flip": "sticky"},
]


class Scripted:
    """Plays by a hash of the last observation, and keeps what it saw."""

    facts: ClassVar = {}

    def __init__(self):
        self.seen = []

    async def decide(self, situation, rng):
        task, percepts = situation.task, [*(turn.percept for turn in situation.past), situation.percept]
        positions = any(percept.positions is not None for percept in percepts)
        told = [vector(task, one, task.budget - i, positions=positions) for i, one in enumerate(percepts)]
        self.seen.append(np.array(told))
        return Decision(joint=task.joints[int(told[-1] @ np.arange(3, 3 + len(told[-1]))) % 4])


def test_what_is_never_told_has_one_value_and_what_may_be_missing_one_more():
    assert sizes(3, positions=True, outcomes=False, budget=None) == (3, 4, 1, 2, 2, 2)
    assert sizes(3, positions=True, gaps=True, budget=5) == (3, 4, 3, 3, 3, 3, 6)


@pytest.mark.parametrize("flip", ["transient", "sticky", "outcome-only"])
@given(seed=st.integers(0, 10_000), trial=st.integers(1, 30), shuffle=st.sampled_from(get_args(Shuffle)))
@settings(max_examples=15, deadline=None)
def test_a_study_shows_a_learned_agent_what_the_environment_shows(flip, seed, trial, shuffle):
    agent = Scripted()
    played = run_trial(agent=agent, p=0.4, flip=flip, modality="symbolic", seed=seed, trial=trial, shuffle=shuffle)
    env = LockboxEnv(p=0.4, flip=flip, shuffle=shuffle, steps_left=True)
    told = [env.reset(seed=seed, options={"trial": trial})[0]]
    for observations, step in zip(agent.seen, played.steps, strict=True):
        assert observations.tolist() == np.array(told).tolist()
        told.append(env.step(played.listing.index(step.decision.joint))[0])
    assert env.trial.ending == played.ending


@pytest.mark.parametrize("asked", CONDITIONS)
@pytest.mark.parametrize("seed", [1, 2])
def test_under_every_condition_it_is_shown_the_same(asked, seed):
    agent, asked = Scripted(), {"modality": "symbolic"} | asked
    played = run_trial(agent=agent, seed=seed, **asked)
    env = LockboxEnv(shuffle="trial", steps_left=True, **asked)
    told = [env.reset(seed=seed)[0]]
    for observations, step in zip(agent.seen, played.steps, strict=True):
        assert observations.tolist() == np.array(told).tolist()
        told.append(env.step(played.listing.index(step.decision.joint))[0])


RGB = np.arange(6 * 5 * 3, dtype=np.uint8).reshape(6, 5, 3)
MILLIMETRES = np.arange(6 * 5, dtype=np.uint16).reshape(6, 5) * 200


def percept(rgb=RGB):
    return Percept(
        pictures=(
            Picture(kind="rgb", png=to_png(rgb)),
            Picture(kind="depth", png=to_png(rgb)),
            Picture(kind="depth16", png=to_png(MILLIMETRES), shown=False),
        )
    )


def test_colours_come_back_as_they_went():
    assert (colours(percept()) == RGB).all()
    assert colours(percept()).dtype == np.uint8


def test_depth_is_what_was_measured_up_to_its_limit():
    metres = distances(percept())
    assert (metres.shape, metres.dtype) == ((6, 5, 1), np.float32)
    assert metres.ravel()[:21].tolist() == pytest.approx([0.2 * i for i in range(21)])
    assert metres.ravel()[21:].max() == 0


def test_an_observation_is_colours_or_both():
    assert (images(percept(), "rgb") == RGB).all()
    assert sorted(images(percept(), "rgbd")) == ["depth", "rgb"]


def test_what_is_not_there_is_no_picture():
    with pytest.raises(ChannelFault, match="no picture of the kind rgb"):
        colours(Percept())
