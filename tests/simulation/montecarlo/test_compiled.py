"""What is compiled computes what the policies compute, compiled or not."""

import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lockprobe.agents.cognitive import RandomMap, SoftmaxMemory
from lockprobe.agents.human_inspired import HumanInspired
from lockprobe.agents.strategies import RandomAgent, RandomNoRepeat, RoundRobin
from lockprobe.boxes.families import box
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.simulation.montecarlo import compiled as compiling
from lockprobe.simulation.montecarlo.compiled import (
    compiled,
    deepest,
    fill,
    joints_in,
    jumps,
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


@settings(max_examples=30, deadline=None)
@given(policy=POLICIES, like=st.sampled_from(FLIPS), seed=st.integers(0, 99))
def test_the_same_functions_run_uncompiled(policy, like, seed):
    pytest.importorskip("numba")
    world = world_of("reset", flip=like.at_rate(0.3), max_steps=20)
    _, one = played(play_trials, policy, world, 3, seed)
    _, other = played(compiled(play_trials), policy, world, 3, seed)
    assert all((a == b).all() for a, b in zip(one, other, strict=True))


def test_a_policy_of_another_class_is_not_taken_for_its_parent():
    class Other(RoundRobin):
        pass

    assert rule_of(Other()) is None
    assert rule_of(RoundRobin()) is not None


@pytest.mark.parametrize("name", ["chain-2", "chain-3", "chain-4", "reset", "random-5-17", "random-8-3"])
def test_a_jump_is_its_steps_one_by_one(name):
    puzzle, world = box(name), world_of(name, flip=OutcomeFlip(), max_steps=20)
    depth = deepest(len(puzzle.joints))
    table, sequences = jumps(scene_of(world), depth), joints_in(len(puzzle.joints), depth)
    assert table.shape == (2 ** len(puzzle.joints), len(puzzle.joints) ** depth)
    assert len({tuple(sequence) for sequence in sequences.tolist()}) == len(sequences)
    assert table.nbytes <= 2**16
    rng = np.random.default_rng(0)
    for start, taken in rng.integers(0, table.shape, (300, 2)).tolist():
        configuration = tuple(at ^ bool(start >> j & 1) for j, at in enumerate(puzzle.initial))
        end = None
        for step, joint in enumerate(sequences[taken].tolist(), 1):
            configuration, moved = puzzle.attempt(configuration, joint)
            if moved and joint == puzzle.target_index:
                end = 256 + step
                break
        shifted = sum((now != at) << j for j, (now, at) in enumerate(zip(configuration, puzzle.initial, strict=True)))
        assert table[start, taken] == (end or shifted)


def test_numbers_are_the_same_compiled_or_not():
    pytest.importorskip("numba")
    for first, offset in ((0, 0), (10**9, 2**16 + 5)):
        source = Counted(3, 4, order=(0, 1, 2, 3), flips=0, draws=9)
        numbers = np.empty((5, 9))
        compiled(fill)(source.key, first, offset, numbers)
        assert (numbers == source._numbers(first, 5, offset, 9)).all()


def test_compiling_waits_until_it_pays(monkeypatch):
    pytest.importorskip("numba")
    monkeypatch.setattr(compiling, "_ASKED", compiling.Counter())
    monkeypatch.setattr(compiling, "WORTH_COMPILING", 100)
    assert [compiling.pays(steps) for steps in (60, 39, 1, 0)] == [False, False, True, True]
    monkeypatch.setitem(sys.modules, "numba", None)
    assert not compiling.pays(1000)
