"""One law, four ways: the loop of a trial, the kernel, exact propagation and Gymnasium play and tell the same."""

from dataclasses import dataclass
from typing import get_args

import gymnasium
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lockprobe.interfaces.gymnasium  # noqa: F401  registers the environment
from lockprobe import run_trial
from lockprobe.agents.policy import Policy
from lockprobe.boxes.box import Shuffle
from lockprobe.foundation.errors import UserMistake
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.simulation import kernel
from lockprobe.simulation.exact import propagate
from lockprobe.simulation.kernel import population


@dataclass(frozen=True, kw_only=True)
class Diary(Policy[tuple]):
    """Remembers every report, and lets the last one bear on its choice; of no family that is known elsewhere."""

    def begin(self, view):
        return ()

    def remember(self, view, memory, told):
        return (*memory, told)

    def probabilities(self, view, memory):
        weights = [1.0 + j for j in range(view.joints)]
        for told in memory[-2:]:
            weights[(told.joint + told.moved + (told.shifted or 0)) % view.joints] += 4
        return tuple(weight / sum(weights) for weight in weights)


AGENTS = (
    "random",
    "random-no-repeat",
    "round-robin",
    "human-inspired",
    "human-inspired:target-last?lapse=0.2",
    "human-inspired:proximity?lapse=0.1",
    "human-inspired:target-first-per-configuration?lapse=0.3",
    "cognitive:softmax-memory?failure=5&recent=2&stay=-2",
    "cognitive:softmax-memory?failure=2&decay=0.8&reset=0.4&target=0.5&closed=1&position=1.5",
    "cognitive:loop-breaker",
    Diary(),
)
READINGS = [
    *(OutcomeFlip(inverts=inverts, keep=keep) for inverts in ("position", "outcome") for keep in (0, 0.5, 1)),
    OutcomeFlip(inverts="position", others="noisy"),
]
PARTS = [OutcomeFlip(part="outcome"), *(OutcomeFlip(part="position", keep=keep) for keep in (0, 0.5))]
TOLD = st.tuples(st.sampled_from(READINGS), st.sampled_from(["state", "outcome", "both"])) | st.tuples(
    st.sampled_from(PARTS), st.just("both")
)
"""What a false report is, and what reports tell; one part of it alone needs both."""


def modality_of(tell):
    return "symbolic" if tell == "both" else f"symbolic?tell={tell}"


@settings(max_examples=25, deadline=None)
@given(
    agent=st.sampled_from(AGENTS),
    name=st.sampled_from(["chain-3", "chain-4", "reset", "common-effect-4", "random-6-2", "chain-8"]),
    told=TOLD,
    p=st.sampled_from([0.0, 0.3, 1.0]),
    seed=st.integers(0, 99),
    repetition=st.integers(1, 3),
    trial=st.integers(1, 5),
    shuffle=st.sampled_from(("trial", *get_args(Shuffle))),
    max_steps=st.integers(1, 24),
)
def test_loop_kernel_and_gymnasium_play_one_trial(agent, name, told, p, seed, repetition, trial, shuffle, max_steps):
    """Joints, outcomes and reports, step by step; the environment attempts the joints that the agent attempted."""
    like, tell = told
    given_ = {"seed": seed, "repetition": repetition, "shuffle": shuffle, "max_steps": max_steps}
    flip = like.at_rate(p)
    recorded = run_trial(agent=agent, box=name, condition=[flip], trial=trial, modality=modality_of(tell), **given_)
    joints = [recorded.joints.index(step.joint) for step in recorded.steps]
    moved, said = ([getattr(step, what) for step in recorded.steps] for what in ("moved", "told_moved"))
    n, rest, solved = len(joints), max_steps - len(joints), recorded.solved

    if given_.pop("shuffle") == "trial":
        found = population(agent, name, p=p, flip=like, modality=modality_of(tell), trials=trial, **given_)
        assert (int(found.steps[-1]), bool(found.solved[-1])) == (n, solved)
        assert found.actions[-1].tolist() == joints + [-1] * rest
        assert found.moved[-1].tolist() == moved + [False] * rest
        assert found.told_moved[-1].tolist() == said + [False] * rest

    world = {"box": name, "condition": [flip], "modality": modality_of(tell)}
    asked = {**world, "shuffle": shuffle, "max_steps": max_steps}
    places = [recorded.listing.index(recorded.labels[joint]) for joint in joints]
    single = gymnasium.make("lockprobe/Lockbox-v0", disable_env_checker=True, **asked)
    many = gymnasium.make_vec("lockprobe/Lockbox-v0", 2, **asked)
    where = {"repetition": repetition, "trial": trial}
    first, _ = single.reset(seed=seed, options=where)
    assert first.tolist() == many.reset(seed=[seed, seed + 1], options=where)[0][0].tolist()
    for step, place in enumerate(places):
        seen, _, over, *_ = single.step(place)
        both, _, ends, *_ = many.step(np.array([place, 0]))
        assert seen.tolist() == both[0].tolist()
        assert (over, bool(ends[0])) == (step == n - 1 and solved,) * 2
        if tell != "outcome":  # what is told of the joints, in panel order
            shown = seen[3:].tolist()
            told_state = [shown[recorded.listing.index(label)] for label in recorded.labels]
            assert "".join(map(str, told_state)) == recorded.steps[step].told_state
        if tell != "state":
            assert (seen[2] == 2) == said[step]


FOLLOWED = [
    *(("human-inspired", "chain-3" if like.others == "noisy" else "chain-4", like, "state") for like in READINGS),
    *(("human-inspired", "chain-4", like, "both") for like in PARTS),
    ("cognitive:perseverant", "chain-4", READINGS[4], "state"),
    ("human-inspired:proximity", "chain-4", READINGS[2], "state"),
    ("human-inspired?lapse=0.2", "chain-3", READINGS[3], "outcome"),
    ("cognitive:softmax-memory?failure=2&stay=-1&position=1.5", "chain-3", READINGS[3], "outcome"),
]


@pytest.mark.parametrize("trials", [2_000, pytest.param(200_000, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("agent", "name", "like", "tell"), FOLLOWED)
def test_the_kernel_has_the_exact_distribution(agent, name, like, tell, trials):
    """Of the steps that solve the box, up to 4.5 standard errors at each."""
    asked = {"modality": modality_of(tell), "max_steps": 8}
    found = population(agent, name, p=0.3, flip=like, trials=trials, **asked)
    exact = np.array(propagate(agent, name, p=0.3, flip=like, **asked).solved)
    assert (np.abs(found.curve - exact) <= 4.5 * np.sqrt(exact * (1 - exact) / trials) + 1e-9).all()
    assert found.curve[-1] == found.success


def test_the_size_of_a_population_and_of_its_pieces_changes_no_trial(monkeypatch):
    whole = population("cognitive:perseverant", p=0.3, trials=500)
    monkeypatch.setattr(kernel, "PIECE", 150)
    part = population("cognitive:perseverant", p=0.3, trials=400)
    for name in ("solved", "steps", "actions", "moved", "told_moved"):
        assert np.array_equal(getattr(part, name), getattr(whole, name)[:400])


def test_mistakes_are_one_line():
    for asked, said in (
        ({"agent": "rundom"}, "no agent is called 'rundom'"),
        ({"box": "chain-9"}, "no box is called 'chain-9'"),
        ({"max_steps": 20_000}, "max_steps: got 20000, expected a whole number from 1 to 10000$"),
        ({"trials": 0}, "trials: got 0, expected a whole number from 1$"),
        ({"flip": OutcomeFlip(only="moved")}, "flip: got .*, expected a flip of every report"),
        ({"trials": 100_000_000}, "steps of all trials: got 2000000000, expected at most 1000000000$"),
    ):
        with pytest.raises(UserMistake, match=f"^{said}"):
            population(**asked)
