"""Loops, redundancy, entropy and heeding of reports in trials with known answers, and chance levels."""

from dataclasses import replace

import numpy as np
import pytest
from builders import SOLUTION, make_trial, play_study, small_study

from lockprobe.report.prose.success import finding
from lockprobe.statistics.behaviour import (
    behaviour,
    has_loop,
    heeded_at_most,
    loop_coverage,
    policy_entropy,
    redundant_share,
)
from lockprobe.statistics.loops.chance import chance_level
from lockprobe.statistics.summary import summarise

AGENT = "llm:local"


def test_a_loop_needs_three_actions_twice():
    assert has_loop(make_trial([0, 1, 0, 0, 1, 0]))
    assert not has_loop(make_trial([0, 0, 0, 0, 0]))
    assert loop_coverage(make_trial([0, 1, 0, 0, 1, 0])) == 1.0
    assert loop_coverage(make_trial([0, 1, 0, 0, 0, 1, 0])) == pytest.approx(6 / 7)
    assert loop_coverage(make_trial([])) == 0.0


def test_redundancy_is_a_pair_of_configuration_and_joint():
    assert redundant_share(make_trial([0, 0, 1, 0])) == 0.5
    assert redundant_share(make_trial([0, 3, 0, 2, 0])) == 0.0
    assert redundant_share(make_trial(SOLUTION)) == 0.0


def test_entropy_in_bits():
    assert policy_entropy(make_trial([0, 1], probabilities=(0.25,) * 4)) == [2.0, 2.0]
    assert policy_entropy(make_trial([0], probabilities=(1.0, 0.0, 0.0, 0.0))) == [0.0]
    assert policy_entropy(make_trial([0])) == []
    found = behaviour([make_trial([0, 1], probabilities=(0.5, 0.5, 0.0, 0.0)), make_trial([0])])
    assert (found.entropy, found.entropy_steps) == (1.0, 2)


def test_chance_is_that_of_exactly_these_lengths():
    found = behaviour([make_trial(SOLUTION), make_trial([0] * 20), make_trial([0] * 3, broken="model")])
    assert found.chance_uniform == pytest.approx((0.0 + 0.80081) / 2, abs=1e-4)
    assert found.chance_no_repeat == pytest.approx(chance_level(20, actions=4, null="no-repeat").probability / 2)
    assert found.loops.n == 2


def test_no_trials_no_numbers():
    found = behaviour([])
    assert (found.coverage, found.chance_uniform, found.redundant_share, found.loops.n) == (None, None, None, 0)
    assert found.chance_no_repeat is None


def only(trials):
    (agent,) = summarise(trials).agents
    return agent


def test_an_agent_that_was_never_told_otherwise_is_not_called_blind():
    """Alike at every p because no report differed: that says nothing about the agent."""
    alike = [make_trial((3, 2, 1, 0), agent=AGENT, p=p, trial=t) for p in (0.0, 0.01) for t in (1, 2, 3)]
    assert not only(alike).blind
    told_otherwise = [
        make_trial((3, 2, 1, 0), agent=AGENT, p=p, trial=t, false_at=(1,) if p else ())
        for p in (0.0, 0.4)
        for t in range(10)
    ]
    assert only(told_otherwise).blind
    assert not only([trial for trial in told_otherwise if trial.trial < 9]).blind


def test_of_the_last_report_nobody_can_say_what_the_agent_would_have_done():
    trials = [
        make_trial((1,), agent=AGENT, p=p, trial=t, budget=1, false_at=(1,) if p else ())
        for p in (0.0, 0.4)
        for t in range(30)
    ]
    assert not only(trials).blind
    assert "whatever it was told" not in finding(only(trials))


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


def test_the_bound_is_that_of_no_success_among_blocks():
    (agent,) = summarise(seldom_reads(0.0, np.random.default_rng(1), whole=False, blocks=30)).agents
    assert agent.heeded == pytest.approx(1 - 0.05 ** (1 / 30))
    assert finding(agent).startswith(
        f"{AGENT} played alike whatever it was told, so it acts on at most 10 % of reports: it solved 0 of 30 trials"
    )
