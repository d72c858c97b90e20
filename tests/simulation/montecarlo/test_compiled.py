"""What is compiled computes what the policies compute, compiled or not."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lockprobe.agents.cognitive import RandomMap, SoftmaxMemory
from lockprobe.agents.human_inspired import HumanInspired
from lockprobe.agents.strategies import RandomAgent, RandomNoRepeat, RoundRobin
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.simulation.montecarlo.compiled import (
    compiled,
    lasting_in,
    numbers_a_step,
    rule_of,
    scene_of,
)
from lockprobe.simulation.montecarlo.compiled_choices import play_trials
from lockprobe.simulation.montecarlo.plain import play_plainly, world_of
from lockprobe.simulation.montecarlo.rules import MEMORY, record
from lockprobe.simulation.montecarlo.streams import Counted

SHARES = st.sampled_from([0.0, 0.3, 1.0]) | st.floats(0, 1)
PULLS = st.floats(-6, 6) | st.sampled_from([0.0, 60.0, -60.0])
POLICIES = st.one_of(
    st.sampled_from([RandomAgent(), RandomNoRepeat(), RoundRobin()]),
    st.builds(
        HumanInspired,
        target=st.sampled_from(["first", "last", "any"]),
        memory=st.sampled_from(["since-move", "configuration", "none"]),
        spare=st.sampled_from(["opened", "moved", "none"]),
        nearest=st.booleans(),
        lapse=SHARES,
    ),
    st.builds(
        SoftmaxMemory,
        target=PULLS,
        closed=PULLS,
        failure=PULLS,
        decay=SHARES,
        reset=SHARES,
        recent=PULLS,
        stay=PULLS,
        position=PULLS,
    ),
    st.builds(RandomMap, window=st.integers(0, 3), avoid=st.sampled_from(["none", "failed"]), lapse=SHARES),
    st.builds(RandomMap, window=st.integers(1, 3), avoid=st.just("last"), lapse=SHARES),
)
FLIPS = [
    *(OutcomeFlip(inverts=inverts, keep=keep) for inverts in ("position", "outcome") for keep in (0, 0.5, 1)),
    OutcomeFlip(inverts="position", others="noisy"),
]
PARTS = [OutcomeFlip(part="outcome"), *(OutcomeFlip(part="position", keep=keep) for keep in (0, 0.5))]
TOLD = st.tuples(st.sampled_from(FLIPS), st.sampled_from(["state", "outcome", "both"])) | st.tuples(
    st.sampled_from(PARTS), st.just("both")
)
"""What a false report is, and what reports tell; one part of it alone needs both."""
BOXES = ("chain-2", "chain-4", "reset", "branched", "random-5-17", "random-8-3")


def room(trials, budget):
    columns = ((trials,), np.int32), ((trials,), bool)
    table = ((trials, budget), np.int8), ((trials, budget), bool), ((trials, budget), bool)
    return tuple(np.zeros(*shape) for shape in (*columns, *table))


def played(play, policy, world, trials, seed):
    """Steps, solved, actions, moved and told of some trials, by a kernel."""
    rule = rule_of(policy)
    source = Counted(seed, len(world.places), order=None, flips=world.budget, draws=world.budget * numbers_a_step(rule))
    found = room(trials, world.budget)
    orders, flips, draws = source.block(0, trials)
    lasting = lasting_in(flips, orders, world.flip)
    play(scene_of(world), rule, record(MEMORY), orders, flips, lasting, draws, *found)
    return source, found


@settings(max_examples=60, deadline=None)
@given(
    policy=POLICIES,
    name=st.sampled_from(BOXES),
    told_by=TOLD,
    p=SHARES,
    budget=st.integers(1, 30),
    seed=st.integers(0, 2**40),
)
def test_a_kernel_plays_what_the_policy_plays(policy, name, told_by, p, budget, seed):
    """Every family, every setting: choice by choice and report by report, on the same numbers."""
    pytest.importorskip("numba")
    like, tell = told_by
    world = world_of(name, flip=like.at_rate(p), max_steps=budget, tell=tell)
    source, (steps, solved, actions, moved, told) = played(compiled(play_trials), policy, world, 4, seed)
    for trial in range(4):
        by_hand = play_plainly(policy, world, *source.luck(trial))
        n = len(by_hand.joints)
        assert (int(steps[trial]), bool(solved[trial])) == (n, by_hand.solved)
        assert actions[trial, :n].tolist() == by_hand.joints
        assert moved[trial, :n].tolist() == by_hand.moved
        assert told[trial, :n].tolist() == by_hand.told_moved
