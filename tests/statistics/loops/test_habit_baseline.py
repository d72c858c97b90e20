"""A blind agent with an agent's habits: its odds on the box, whose habits they are, and who is told apart from it."""

import math

import numpy as np
import pytest
from builders import make_trial, play_study, small_study

from lockprobe.boxes.families import box
from lockprobe.boxes.solve import random_curve
from lockprobe.report.prose.hypothesis_tests import note_said, why_missing
from lockprobe.statistics.inference.hazard import loop_hazard
from lockprobe.statistics.loops import habit_baseline, onset_batch
from lockprobe.statistics.loops.habit_baseline import Actions, actions_of, blind_trials, played_out
from lockprobe.statistics.loops.null_models import chain_walks
from lockprobe.statistics.outcomes import outcomes
from lockprobe.statistics.summary import summarise

CHAIN = box("chain-4")
TARGET = CHAIN.target_index
P = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)


def walks(share, at, trials, rng, *, after_last=False):
    """One joint (or the one so many places after the last) with that probability at every step, the others alike."""
    same = np.roll(np.eye(4), at, axis=1) if after_last else np.tile(np.eye(4)[at], (4, 1))
    after = share * same + (1 - share) / 3 * (1 - same)
    first = np.full(4, 0.25) if after_last else after[0]
    return chain_walks(first, after, rng.random((20, trials))).T.astype(np.int64)


def played(joints, p, listed=None):
    """Outcomes and actions of walks that were played until solved."""
    found = played_out(joints, p, CHAIN)
    own = np.tile(np.arange(4), (len(p), 1))
    ways = np.stack([own, own, own if listed is None else listed])
    rows = tuple(row[:n] for row, n in zip(joints, found.length, strict=True))
    return found, Actions(p=p, joints=rows, ways=ways, budget=20)


def test_what_is_played_out_is_what_the_box_does():
    trials = play_study(small_study(["random", "round-robin"], trials=20))
    found = actions_of(trials, CHAIN)
    joints = np.array([[*row, *[row[-1]] * (20 - len(row))] for row in found.joints])
    again, truly = played_out(joints, found.p, CHAIN), outcomes(trials)
    for name in ("dose", "length", "solved", "onset"):
        assert getattr(again, name).tolist() == getattr(truly, name).tolist()


def test_a_uniform_agents_twin_solves_as_often_as_exact_chance():
    rng = np.random.default_rng(1)
    _, actions = played(rng.integers(0, 4, (3000, 20)), np.zeros(3000))
    twin = blind_trials(actions, CHAIN, rng)
    assert twin is not None
    for step in (5, 10, 20):
        share = float(np.mean(twin.solved & (twin.length <= step)))
        assert share == pytest.approx(random_curve(CHAIN, step)[-1], abs=0.025)


def test_each_p_has_habits_of_its_own_and_its_share_of_trials():
    rows = [make_trial([1] * 20, p=0.0, trial=1), *(make_trial([2, 3] * 10, p=0.3, trial=i) for i in range(3))]
    twin = blind_trials(actions_of(rows, CHAIN), CHAIN, np.random.default_rng(0))
    assert twin is not None
    assert len(twin) >= habit_baseline.SIMULATED
    assert np.mean(twin.dose == 0.0) == pytest.approx(0.25)
    assert not twin.solved.any()


@pytest.mark.parametrize("way", ["joints", "labels", "list"])
def test_habits_are_of_what_predicts_best(way):
    """Round robin over a shuffled order solves the box soon; the joints alone look random."""
    rng = np.random.default_rng(3)
    order = np.argsort(rng.random((400, 4)), axis=1) if way != "joints" else np.tile(np.arange(4), (400, 1))
    joints = np.take_along_axis(order, walks(0.9, 1, 400, rng, after_last=True), axis=1)
    found, actions = played(joints, np.zeros(400))
    ways = {"joints": 0, "labels": 1, "list": 2}
    others = np.argsort(rng.random((3, 400, 4)), axis=2)
    others[ways[way]] = order
    twin = blind_trials(Actions(p=actions.p, joints=actions.joints, ways=others, budget=20), CHAIN, rng)
    assert twin is not None
    assert twin.solved.mean() == pytest.approx(found.solved.mean(), abs=0.06)
    assert np.mean(twin.onset > 0) == pytest.approx(np.mean(found.onset > 0), abs=0.06)


def test_labels_and_places_in_the_list_are_read_from_the_trial():
    from dataclasses import replace

    trial = replace(make_trial([0, 1]), labels=tuple("CADB"), listing=tuple("BDCA"))
    found = actions_of([trial], CHAIN)
    assert found.ways[:, 0].tolist() == [[0, 1, 2, 3], [1, 3, 0, 2], [3, 2, 0, 1]]
    assert [row.tolist() for row in found.joints] == [[0, 1]]
    assert blind_trials(actions_of([], CHAIN), CHAIN, np.random.default_rng(0)) is None


@pytest.mark.parametrize(("share", "at", "after_last"), [(0.4, TARGET, False), (0.5, 0, True), (0.8, 1, True)])
def test_a_blind_agent_is_not_told_apart_from_its_twin(share, at, after_last):
    """It was told apart from an odds ratio of 1: the target with .4, the last joint again with .5, round robin."""
    against_one, against_twin, p = 0, 0, np.repeat(P, 150)
    for number in range(4):
        rng = np.random.default_rng([number, at])
        found, actions = played(walks(share, at, len(p), rng, after_last=after_last), p)
        against_one += loop_hazard(found).p_value < 0.05
        effect = loop_hazard(found, blind_trials(actions, CHAIN, rng))
        against_twin += effect.p_value < 0.05
        assert effect.blind.error < 0.05
        assert effect.low < effect.odds_ratio < effect.high
    assert against_one >= 2
    assert against_twin <= 1


def test_harm_beyond_habits_is_found():
    """Any joint but the last; once a loop is complete, nearly always the last again."""
    rng, p = np.random.default_rng(5), np.repeat(P, 100)
    joints = walks(0.0, 0, len(p), rng, after_last=True)
    onset = onset_batch(joints)
    for step in range(1, 20):
        stuck = (onset > 0) & (onset <= step) & (rng.random(len(p)) < 0.9)
        joints[:, step] = np.where(stuck, joints[:, step - 1], joints[:, step])
    found, actions = played(joints, p)
    twin = blind_trials(actions, CHAIN, rng)
    effect = loop_hazard(found, twin)
    assert effect.odds_ratio < effect.blind.odds_ratio
    assert effect.direction == -1
    assert effect.p_value < 0.001


def test_the_test_asks_for_the_twins_odds_ratio():
    """Where the agent has exactly its twin's odds ratio nothing is found, however far from 1 that is."""
    rng, p = np.random.default_rng(2), np.repeat(P, 100)
    found, _ = played(walks(0.4, TARGET, len(p), rng), p)
    same = loop_hazard(found, found)
    assert same.blind.odds_ratio == same.odds_ratio
    assert same.p_value == pytest.approx(1.0)
    alone = loop_hazard(found)
    assert (alone.blind, alone.odds_ratio, alone.low, alone.high) == (None, same.odds_ratio, same.low, same.high)
    error = math.log(alone.high / alone.low) / (2 * 1.959964)
    assert same.blind.error == pytest.approx(error)


def test_without_an_odds_ratio_of_the_twin_there_is_no_test():
    rng = np.random.default_rng(0)
    found, _ = played(rng.integers(0, 4, (200, 20)), np.zeros(200))
    never, _ = played(np.zeros((50, 20), dtype=np.int64), np.zeros(50))
    effect = loop_hazard(found, never)
    assert (effect.p_value, effect.blind, effect.direction) == (None, None, 0)
    assert why_missing(effect.note).startswith("No test")
    assert loop_hazard(found).p_value is not None


def test_a_summary_names_the_twin_where_the_box_is_known(monkeypatch):
    monkeypatch.setattr(habit_baseline, "SIMULATED", 4000)
    trials = play_study(small_study(["human-inspired"], trials=15))
    (known,), (unknown,) = summarise(trials, CHAIN).agents, summarise(trials).agents
    one, two = ([t for t in agent.inference.tests if t.question == "harm"][:2] for agent in (known, unknown))
    assert all(
        test.baseline > 0 and f"{test.baseline:.2f}" in note_said(test.name, baseline=test.baseline) for test in one
    )
    assert [test.baseline for test in two] == [None, None]
    assert all("odds ratio of 1" in note_said(test.name) for test in two)
    assert summarise(trials, CHAIN) == summarise(trials[::-1], CHAIN)
