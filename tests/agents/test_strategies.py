"""Strategies that look at nothing, by their exact success and by their rules."""

import pytest

from lockprobe import propagate, run_trial
from lockprobe.boxes.families import box
from lockprobe.boxes.solve import random_no_repeat_success, random_success


def play(agent, n, p=0.0, **settings):
    return [run_trial(agent=agent, p=p, trial=i, seed=3, **settings) for i in range(1, n + 1)]


def share(trials):
    return sum(trial.solved for trial in trials) / len(trials)


def test_random_agents_reach_their_exact_success():
    n = 150
    for agent, exact in (
        ("random", random_success(box())),
        ("random-no-repeat", random_no_repeat_success(box())),
    ):
        assert propagate(agent).success == pytest.approx(exact)
        assert abs(share(play(agent, n)) - exact) < 4 * (exact * (1 - exact) / n) ** 0.5


def test_random_no_repeat_never_repeats():
    for trial in play("random-no-repeat", 50):
        assert all(a != b for a, b in zip(trial.actions, trial.actions[1:], strict=False))


def test_round_robin_goes_through_the_listing_and_always_solves_chain_4():
    for trial in play("round-robin", 100, p=0.6):
        labels = dict(zip(trial.joints, trial.labels, strict=True))
        told = [labels[joint] for joint in trial.actions]
        assert told == (list(trial.listing) * 5)[: len(told)]
        assert trial.solved
        assert len(trial.steps) <= 13
