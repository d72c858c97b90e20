"""Strategies by their published figures and by their rules."""

import pytest

from lockprobe import run_trial
from lockprobe.lockbox.families import box
from lockprobe.lockbox.solve import random_no_repeat_success, random_success


def play(agent, n=300, p=0.0, **settings):
    return [run_trial(agent=agent, p=p, trial=i, seed=3, **settings) for i in range(1, n + 1)]


def share(trials):
    return sum(trial.solved for trial in trials) / len(trials)


def test_random_agents_reach_their_exact_success():
    n = 1500
    for agent, exact in (
        ("random", random_success(box())),
        ("random-no-repeat", random_no_repeat_success(box())),
    ):
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


def test_human_inspired_has_the_reference_curve():
    """Exactly 5/6 by step 9, all by step 10 (paper, Sec. 3.1: 80 % within 9 steps, 100 % in all)."""
    n = 600
    trials = play("human-inspired", n)
    assert share(trials) == 1.0
    steps = [len(trial.steps) for trial in trials]
    assert (min(steps), max(steps)) == (7, 10)
    by_nine = sum(s <= 9 for s in steps) / n
    assert abs(by_nine - 5 / 6) < 4 * (5 / 36 / n) ** 0.5
    assert abs(sum(steps) / n - 8.5) < 0.15


@pytest.mark.parametrize("flip", ["transient", "sticky", "outcome-only"])
def test_noise_only_hurts_the_human_inspired_strategy(flip):
    shares, nines = [], []
    for p in (0.0, 0.3, 0.6):
        trials = play("human-inspired", 200, p=p, flip=flip)
        shares.append(share(trials))
        nines.append(sum(t.solved and len(t.steps) <= 9 for t in trials))
    assert shares == sorted(shares, reverse=True)
    assert nines[0] > nines[1] > nines[2]
    assert shares[2] < 0.85


def test_human_inspired_never_retries_a_failed_joint_before_a_perceived_move():
    for trial in play("human-inspired", 100, p=0.3):
        failed = set()
        for step in trial.steps:
            if len(failed) < len(trial.joints):
                assert step.joint not in failed
            if step.told_moved:
                failed.clear()
            else:
                failed.add(step.joint)


def test_strategies_say_what_they_were_told():
    for trial in play("human-inspired", 20, p=0.5):
        for before, step in zip(trial.steps, trial.steps[1:], strict=False):
            assert step.decision.claimed == ("moved" if before.told_moved else "blocked")
        assert trial.steps[0].decision.claimed is None
