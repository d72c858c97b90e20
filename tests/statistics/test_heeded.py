"""Agents that play alike whatever they are told, and how many reports they may still heed."""

from dataclasses import replace

import numpy as np
import pytest
from builders import make_trial, play_study, small_study

from lockprobe.statistics.outcomes import heeded_at_most

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


def test_an_agent_that_heeds_reports_is_not_called_blind_in_small_studies():
    for seed in range(15):
        study = replace(small_study(("human-inspired",), p=(0.0, 0.05), repetitions=1, trials=2), seed=seed)
        assert heeded_at_most(play_study(study)) is None


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


@pytest.mark.parametrize("share", [0.02, 0.05, 0.2, 0.3])
@pytest.mark.parametrize("whole", [False, True])
def test_what_a_blind_agent_may_still_heed_is_bounded(share, whole):
    """A bound below the true share is said in at most 5 % of studies, also if whole trials are heeded."""
    rng = np.random.default_rng([int(100 * share), whole])
    bounds = [heeded_at_most(seldom_reads(share, rng, whole=whole)) for _ in range(150)]
    wrong = [bound is not None and bound < share for bound in bounds]
    assert np.mean(wrong) <= 0.05
    assert share > 0.05 or whole or any(bound is not None for bound in bounds)
