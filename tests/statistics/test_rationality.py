"""Actions judged by an ideal observer: by hand, by identity and by enumeration."""

import numpy as np
import pytest
from builders import make_trial
from clumsy import HAND

from lockprobe import run_trial
from lockprobe.agents.ideal_observer import IdealObserver
from lockprobe.boxes.beliefs.structures import interlocks
from lockprobe.boxes.families import box
from lockprobe.statistics import rationality as module
from lockprobe.statistics.rationality import optimal_actions
from lockprobe.statistics.rules import Rules, unbroken
from lockprobe.testing import play_trials

FLIPS = ("re-observed", "integrated", "outcome-only")


def played(agent, n, p=0.0, **settings):
    return [run_trial(agent=agent, p=p, trial=i, seed=4, **settings) for i in range(1, n + 1)]


def counts(trials, *more):
    share, _ = optimal_actions(trials, *more)
    return share.count, share.n


@pytest.mark.parametrize("flip", FLIPS)
def test_an_ideal_observer_is_optimal_to_itself(flip):
    assert optimal_actions(played(IdealObserver(noise="naive"), 12, p=0.3, flip=flip))[0].value == 1


def test_a_trial_is_a_cluster_and_broken_trials_are_left_out():
    trials = played("human-inspired", 6, p=0.3)
    share, _ = optimal_actions([*trials, make_trial([1], broken="model")])
    assert (share.clusters, share.n) == (6, sum(len(trial.steps) for trial in trials))
    assert share.count == sum(counts([trial])[0] for trial in trials)


def test_what_other_trials_left_behind_changes_nothing(monkeypatch):
    """A report is the same whichever process has worked at whichever agent before."""
    trials = [*played("random", 4, p=0.6), *played("cognitive:perseverant", 4, p=0.6)]
    module._known.clear()
    module._first.cache_clear()
    fresh = [counts([trial]) for trial in trials]
    monkeypatch.setattr(module, "_MANY", 1)
    module._first.cache_clear()
    assert [counts([trial]) for trial in trials[::-1]] == fresh[::-1]
    assert counts(trials) == tuple(map(sum, zip(*fresh, strict=True)))


def values_of(known):
    """Expected steps of every set of interlocks and configuration, by sweeps; what a missed joint says is not known."""
    alive = frozenset(np.flatnonzero(known.distance[:, 0] < 255).tolist())
    ways, queue = {}, [(alive, 0)]
    while queue:
        there, here = state = queue.pop()
        if state in ways:
            continue
        ways[state] = []
        for joint in range(known.joints):
            moved = frozenset(s for s in there if known.masks[here][joint] >> s & 1)
            parts = [(moved, (moved, here ^ 1 << joint) if joint else None), (there - moved, (there - moved, here))]
            ways[state].append([(len(part) / len(there), then) for part, then in parts if part])
            queue += [then for part, then in parts if part and then is not None]
    values = dict.fromkeys(ways, 0.0)
    for _ in range(60):
        values = {state: min(_costs(found, values)) for state, found in ways.items()}
    return {state: _costs(found, values) for state, found in ways.items()}


def _costs(ways, values):
    return [1 + sum(share * (values[then] if then else 0.0) for share, then in way) for way in ways]


def test_actions_before_a_broken_rule_are_judged_as_by_enumeration_and_none_after_it():
    plain, known = box("chain-3"), interlocks("single-parent", 3)
    values = values_of(known)
    trials = play_trials("random", 10, box="chain-3", plant=f"{HAND}?misses=1;3;5&forces=4")
    judged = Rules(plain).judged
    firsts = [unbroken(trial, judged(trial)) for trial in trials]
    assert {0, 2} < {*firsts}
    optimal = 0
    for trial, first in zip(trials, firsts, strict=True):
        numbers = {joint: i for i, joint in enumerate(dict.fromkeys((trial.target, *trial.actions, *trial.joints)))}
        alive, here = frozenset(range(len(known))), 0
        for step in trial.steps[:first]:
            joint, costs = numbers[step.joint], values[alive, here]
            optimal += costs[joint] < min(costs) + 1e-9
            alive = frozenset(s for s in alive if (known.masks[here][joint] >> s & 1) == step.moved)
            here ^= step.moved << joint
    assert counts(trials, judged) == (optimal, sum(firsts))
    assert not optimal_actions(trials, judged)[1]
    assert optimal_actions(trials)[1]  # what they were told of these attempts no interlock explains
