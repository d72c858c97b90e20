"""Trials as columns: what the tests look at is what the records say; agents that play alike whatever they are told."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from builders import SOLUTION, make_trial

from lockprobe.statistics.outcomes import heeded_at_most, outcomes, solved_in_pairs


def test_pairs_are_trials_that_both_have():
    failed = (0,) * 20
    first = outcomes([make_trial(SOLUTION, trial=3), make_trial(failed, trial=1), make_trial(SOLUTION, trial=2)])
    second = outcomes([make_trial(SOLUTION, trial=1), make_trial(failed, trial=3), make_trial(failed, trial=4)])
    assert solved_in_pairs(first, second).tolist() == [[False, True], [True, False]]
    assert solved_in_pairs(first, second).dtype == np.bool_
    assert solved_in_pairs(first, outcomes([make_trial(SOLUTION, trial=3, repetition=2)])).shape == (0, 2)


AGENT = "llm:local"


def alike(reports, **more):
    """Trials told the truth and lied to in the first of their steps, acted in alike."""
    return [
        make_trial((3, 2, 1, 0), agent=AGENT, p=p, trial=t, **more | {"false_at": (1,) if p else ()})
        for p in (0.0, 0.4)
        for t in range(reports)
    ]


def test_an_agent_is_blind_if_ten_reports_differed_and_none_of_its_actions():
    assert heeded_at_most(alike(9)) is None
    assert heeded_at_most(alike(10)) == pytest.approx(1 - 0.05 ** (1 / 10))
    heeds = make_trial((3, 1, 2, 0), agent=AGENT, p=0.4, trial=0, false_at=(1,))
    assert heeded_at_most([*alike(10)[:-1], heeds]) is None
    last = [replace(trial, steps=trial.steps[:1]) for trial in alike(30)]  # nobody knows what it would have done next
    assert heeded_at_most(last) is None


def seldom_reads(share, rng, *, whole, blocks=12, reports=3):
    """Trials at two flip rates of an agent that heeds this share of false reports, or of trials, by trying D."""
    trials = []
    for t in range(blocks):
        trials.append(make_trial((3,) * 8, agent=AGENT, p=0.0, trial=t, budget=8))
        reads = np.repeat(rng.random(1), reports) < share if whole else rng.random(reports) < share
        actions = [3, *np.where(reads, 2, 3).tolist()] + [3] * (7 - reports)
        false_at = tuple(range(1, reports + 1))
        trials.append(make_trial(actions, agent=AGENT, p=0.4, trial=t, budget=8, false_at=false_at))
    return trials


@pytest.mark.parametrize(
    ("share", "whole"),
    [
        (0.05, True),
        *(pytest.param(*case, marks=pytest.mark.slow) for case in product([0.02, 0.05, 0.2, 0.3], [False, True])),
    ],
)
def test_what_a_blind_agent_may_still_heed_is_bounded(share, whole):
    """A bound below the true share is said in at most 5 % of studies, also if whole trials are heeded."""
    rng = np.random.default_rng([int(100 * share), whole])
    bounds = [heeded_at_most(seldom_reads(share, rng, whole=whole)) for _ in range(150)]
    wrong = [bound is not None and bound < share for bound in bounds]
    assert np.mean(wrong) <= 0.05
    assert share > 0.05 or whole or any(bound is not None for bound in bounds)
