"""Populations: the trials of a study, action by action, or as probable ones; by every way of playing them the same."""

import sys
from collections import Counter
from typing import get_args

import numpy as np
import pytest
from diary import Diary, as_recorded
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2, chi2_contingency

from lockprobe import run_trial
from lockprobe.boxes.box import Shuffle
from lockprobe.boxes.families import box
from lockprobe.boxes.solve import random_curve
from lockprobe.foundation.errors import BadValue
from lockprobe.simulation.exact.propagation import propagate
from lockprobe.simulation.montecarlo import compiled as compiling
from lockprobe.simulation.montecarlo.populations import population
from lockprobe.statistics.loops import cover, onset

SPECS = (
    "random",
    "random-no-repeat",
    "round-robin",
    "human-inspired",
    "human-inspired:target-last?lapse=0.2",
    "human-inspired:target-any",
    "human-inspired:proximity?lapse=0.1",
    "human-inspired:per-configuration",
    "human-inspired:target-first-per-configuration?lapse=0.3",
    "cognitive:softmax-memory?failure=5&recent=2&stay=-2",
    "cognitive:softmax-memory?failure=2&decay=0.8&reset=0.4&target=0.5&closed=1&position=1.5",
    "cognitive:random-map",
    "cognitive:random-map?window=1&avoid=last",
    "cognitive:random-map?window=2&avoid=failed&lapse=0.1",
)
KINDS = ("transient", "sticky", "independent", "re-observed", "integrated", "outcome-only")
SETTINGS = {
    "agent": st.sampled_from(SPECS),
    "name": st.sampled_from(["chain-3", "chain-4", "reset", "common-effect-4", "random-6-2"]),
    "flip": st.sampled_from(KINDS),
    "p": st.sampled_from([0.0, 0.2, 0.5, 1.0]),
    "seed": st.integers(0, 99),
    "shuffle": st.sampled_from(get_args(Shuffle)),
    "max_steps": st.integers(1, 24),
}
COLUMNS = ("solved", "steps", "actions", "moved", "told_moved")


@pytest.fixture(autouse=True)
def at_once(monkeypatch):
    """Compiles whatever can be compiled."""
    pytest.importorskip("numba")
    monkeypatch.setattr(compiling, "WORTH_COMPILING", 0)


def same(one, other):
    return all(np.array_equal(getattr(one, name), getattr(other, name)) for name in COLUMNS)


def played_plainly(*args, **kwargs):
    """The same population on a machine without numba."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "numba", None)
        return population(*args, **kwargs)


@settings(max_examples=60, deadline=None)
@given(**SETTINGS, repetition=st.integers(1, 3), tell=st.sampled_from(["both", "state"]))
def test_the_trials_of_a_study_are_those_on_record(agent, name, flip, p, seed, shuffle, max_steps, repetition, tell):
    """Of every kind of agent, under every kind of flip, on any box: joints, outcomes and reports, step by step."""
    given_ = {"p": p, "flip": flip, "seed": seed, "repetition": repetition, "shuffle": shuffle, "max_steps": max_steps}
    given_["modality"] = "symbolic" if flip == "outcome-only" else f"symbolic?tell={tell}"
    found = population(agent, name, trials=2, record=True, **given_)
    for i in range(2):
        joints, moved, told, solved = as_recorded(run_trial(agent=agent, box=name, trial=i + 1, **given_))
        n = len(joints)
        assert (int(found.steps[i]), bool(found.solved[i])) == (n, solved)
        assert found.actions[i].tolist() == joints + [-1] * (max_steps - n)
        assert found.moved[i].tolist() == moved + [False] * (max_steps - n)
        assert found.told_moved[i].tolist() == told + [False] * (max_steps - n)


@settings(max_examples=40, deadline=None)
@given(**SETTINGS, streams=st.sampled_from(["study", "fast"]))
def test_without_numba_the_same_trials_are_played(agent, name, flip, p, seed, shuffle, max_steps, streams):
    given_ = {"p": p, "flip": flip, "seed": seed, "shuffle": shuffle, "max_steps": max_steps, "streams": streams}
    compiled_, plain = (play(agent, name, trials=3, record=True, **given_) for play in (population, played_plainly))
    assert same(compiled_, plain)


@pytest.mark.parametrize("agent", ["random", "round-robin", "cognitive:softmax-memory?failure=5&position=1"])
def test_neither_threads_nor_the_size_of_the_population_change_a_trial(agent):
    given_ = {"p": 0.3, "streams": "fast", "record": True}
    whole = population(agent, trials=9_000, threads=3, **given_)
    assert same(whole, population(agent, trials=9_000, threads=1, **given_))
    part = population(agent, trials=100, **given_)
    assert all(np.array_equal(getattr(part, name), getattr(whole, name)[:100]) for name in COLUMNS)


@pytest.mark.parametrize("name", ["chain-2", "chain-3", "chain-4", "random-5-17", "branched", "random-8-3"])
@pytest.mark.parametrize("max_steps", [1, 7, 20, 33])
def test_several_steps_by_one_number_are_the_steps_one_by_one(name, max_steps):
    given_ = {"trials": 3_000, "max_steps": max_steps, "streams": "fast"}
    at_once, recorded = population("random", name, **given_), population("random", name, record=True, **given_)
    assert np.array_equal(at_once.solved, recorded.solved)
    assert np.array_equal(at_once.steps, recorded.steps)


@pytest.mark.parametrize(
    ("kind", "shares"),
    [
        ("memoryless", (0.467, 0.530, 0.530)),
        ("re-observed", (0.467, 0.530, 0.530)),
        ("latched", (0.575, 0.629, 0.637)),
        ("integrated", (0.562, 0.629, 0.631)),
    ],
)
def test_an_agent_that_maps_states_gains_most_where_false_positions_stay(kind, shares):
    """Shares of 200 000 trials of another program; these are 20 000, with a standard error of .0035."""
    agent = "cognitive:random-map?avoid=last"
    found = [population(agent, p=p, flip=kind, trials=20_000, streams="fast").success for p in (0.2, 0.4, 0.6)]
    assert found == pytest.approx(shares, abs=0.014)


def misfit(found, shares):
    """How improbable the steps at which trials were solved are if these are the true shares by step."""
    trials = len(found)
    expected = trials * np.append(np.diff(shares), 1 - shares[-1])
    ends = np.where(found.solved, found.steps, len(shares))
    counted = np.bincount(ends, minlength=len(shares) + 1)[1:]
    assert not counted[expected < 1e-6].any()
    rare = expected < 5
    expected = np.append(expected[~rare], expected[rare].sum())
    counted = np.append(counted[~rare], counted[rare].sum())[expected > 0]
    expected = expected[expected > 0]
    statistic = 2 * (counted[counted > 0] * np.log(counted[counted > 0] / expected[counted > 0])).sum()
    return chi2.sf(max(statistic, 0), max(len(expected) - 1, 1))


AS_4_5_SIGMA = 6.8e-6
EXACT = [
    ("random", "chain-4", 0.0, "transient"),
    ("random", "random-5-17", 0.3, "sticky"),
    ("random-no-repeat", "reset", 0.2, "transient"),
    ("round-robin", "chain-4", 0.0, "transient"),
    *(("human-inspired", "chain-4", 0.3, flip) for flip in KINDS),
    *((f"human-inspired:{preset}", "chain-4", 0.2, "sticky") for preset in ("target-last", "target-any", "proximity")),
    ("human-inspired:target-first-per-configuration", "reset", 0.0, "transient"),
    ("human-inspired:per-configuration", "chain-4", 0.0, "transient"),
    ("human-inspired?lapse=0.2", "reset", 0.5, "outcome-only"),
    ("cognitive:softmax-memory?failure=2&target=0.5&closed=1&recent=0.7", "chain-4", 0.3, "sticky"),
    ("cognitive:softmax-memory?failure=2&stay=-1&position=1.5", "chain-3", 0.3, "outcome-only"),
]


@pytest.mark.parametrize(("agent", "name", "p", "flip"), EXACT)
def test_counted_numbers_give_the_exact_distribution(agent, name, p, flip):
    """The step that solves the box, over 200 000 trials: G-test at the level of 4.5 standard errors, and the mean."""
    found = population(agent, name, p=p, flip=flip, trials=200_000, streams="fast")
    exact = propagate(agent, name, p=p, flip=flip)
    assert misfit(found, exact.solved) > AS_4_5_SIGMA
    error = (exact.success * (1 - exact.success) / 200_000) ** 0.5
    assert abs(found.success - exact.success) <= 4.5 * error + 1e-12
    assert found.curve[-1] == found.success


def test_the_test_of_distributions_can_fail():
    found = population("random", trials=200_000, streams="fast")
    assert misfit(found, random_curve(box("chain-4"))) > AS_4_5_SIGMA
    assert misfit(found, propagate("cognitive:softmax-memory?recent=0.05").solved) < AS_4_5_SIGMA


@pytest.mark.parametrize("flip", ["sticky", "outcome-only"])
@pytest.mark.parametrize("agent", [spec for spec in SPECS if "map" in spec or "decay" in spec])
def test_counted_numbers_and_those_of_a_study_give_the_same_distribution(agent, flip):
    """Of agents that cannot be propagated: steps to solve of two times 3 000 trials, at 4.5 standard errors."""
    ends = [
        np.where(found.solved, found.steps, 21)
        for found in (population(agent, p=0.3, flip=flip, trials=3_000, streams=kind) for kind in ("study", "fast"))
    ]
    table = np.array([np.bincount(column, minlength=22) for column in ends])
    assert chi2_contingency(table[:, table.sum(0) > 20]).pvalue > AS_4_5_SIGMA


def test_a_small_map_has_its_exact_course_too():
    """Of three joints in five steps, where it can still be followed."""
    for flip in sorted({*KINDS} - {"independent"}):  # which has too many states
        given_ = {"p": 0.3, "flip": flip, "max_steps": 5}
        exact = propagate("cognitive:random-map?avoid=last&lapse=0.1", "chain-3", **given_)
        found = population(
            "cognitive:random-map?avoid=last&lapse=0.1", "chain-3", trials=50_000, streams="fast", **given_
        )
        assert misfit(found, exact.solved) > AS_4_5_SIGMA


def test_flips_at_a_smaller_p_are_among_those_at_a_larger_one():
    for streams in ("study", "fast"):
        flipped = []
        for p in (0.1, 0.3, 0.8):
            found = population("round-robin", trials=300, p=p, streams=streams, record=True, shuffle="never")
            flipped.append(found.moved != found.told_moved)
        assert (flipped[0] <= flipped[1]).all()
        assert (flipped[1] <= flipped[2]).all()
        assert flipped[1].sum() / found.steps.sum() == pytest.approx(0.3, abs=0.03)


def test_loops_of_a_population_are_those_of_its_trials():
    found = population("random-no-repeat", trials=400, streams="fast", record=True)
    loops = found.loops()
    for i in range(400):
        actions = found.actions[i, : found.steps[i]].tolist()
        assert (loops.n[i], loops.onset[i], loops.covered[i]) == (len(actions), onset(actions), cover(actions).covered)
    assert found.loops(min_length=2).any_loop.sum() > loops.any_loop.sum()


def test_any_policy_plays_the_trials_of_a_study():
    found = population(Diary(), "reset", trials=3, p=0.3, record=True)
    for i in range(3):
        joints, _, told, _ = as_recorded(run_trial(agent=Diary(), box="reset", p=0.3, trial=i + 1))
        assert found.actions[i, : found.steps[i]].tolist() == joints
        assert found.told_moved[i, : found.steps[i]].tolist() == told
    assert (found.agent, found.world.name, len(found)) == ("Diary", "reset", 3)


def test_a_seed_is_one_population():
    one, again, other = (population(trials=2_000, seed=seed, streams="fast").steps for seed in (5, 5, 6))
    assert np.array_equal(one, again)
    assert Counter(one.tolist()) != Counter(other.tolist())


def test_mistakes_are_one_line():
    with pytest.raises(BadValue, match=r"^streams: got 'fast', expected study, since Diary is none that is compiled$"):
        population(Diary(), streams="fast")
    with pytest.raises(BadValue, match=r"^streams: got 'quick', expected one of study, fast$"):
        population(streams="quick")
    with pytest.raises(BadValue, match=r"^trials: got 0, expected a whole number from 1 to 100000000$"):
        population(trials=0)
    with pytest.raises(BadValue, match=r"^steps to record: got 2000000000, expected at most 1000000000$"):
        population(trials=100_000_000, record=True)
    with pytest.raises(BadValue, match=r"^threads: got 0"):
        population(threads=0)
    with pytest.raises(BadValue, match=r"^record: got False, expected a population with its actions recorded$"):
        population(trials=1).loops()
