"""Trials that broke: found where they select, and nothing concluded that hangs on what became of them."""

import numpy as np
import pytest
from builders import SOLUTION, make_trial
from known_truth import simulated

from lockprobe.foundation.seeds import generator
from lockprobe.report.prose.success import finding
from lockprobe.simulation.power.worlds import Design
from lockprobe.statistics.inference.broken_trials import broken_shares, completed, worst_case_difference
from lockprobe.statistics.inference.difference import any_difference
from lockprobe.statistics.inference.infer import infer
from lockprobe.statistics.outcomes import broken_off, outcomes
from lockprobe.statistics.summary import summarise

AGENT = "llm:local"


def at(p, solved, failed, broken):
    """Trials at one p: so many solved, failed and broken, in an order of luck that differs between values of p."""
    kinds = [SOLUTION] * solved + [(int(10 * p) % 4, *(0,) * 19)] * failed + [None] * broken
    order = np.random.default_rng(int(100 * p)).permutation(len(kinds))
    return [
        make_trial((0, 1), agent=AGENT, p=p, trial=i, broken="reply")
        if kinds[place] is None
        else make_trial(kinds[place], agent=AGENT, p=p, trial=i)
        for i, place in enumerate(order, 1)
    ]


def agent_of(*groups):
    (agent,) = summarise([trial for group in groups for trial in group]).agents
    return agent


def test_what_remains_of_a_condition_that_breaks_is_no_finding():
    """A third solved everywhere; at 0.6 seven of ten break, and of those that remain most are solved."""
    groups = at(0.0, 27, 63, 0), at(0.3, 27, 63, 0), at(0.6, 21, 6, 63)
    agent = agent_of(*groups)
    assert infer(outcomes([trial for group in groups for trial in group]), generator(1)).difference.p_value < 0.05
    assert not agent.contrast.detectable
    said = finding(agent)
    assert said.startswith("Trials of llm:local broke more often under some conditions than under others")
    assert "63 of 90 at a flip rate of 0.6" in said
    assert "more often when each" not in said


def test_a_difference_that_holds_whatever_became_of_them_is_concluded():
    agent = agent_of(at(0.0, 3, 27, 0), at(0.6, 26, 0, 4))
    assert agent.contrast.detectable
    found = agent.contrast.difference
    assert found.if_unsolved.value == pytest.approx(23 / 30)
    assert found.if_solved.value == pytest.approx(27 / 30)
    assert found.p_value == max(found.exchange, found.if_unsolved.p_value, found.if_solved.p_value, found.p_value)
    assert "+77 points with broken trials counted as unsolved, +90" in finding(agent)


def test_breaks_that_are_as_frequent_everywhere_are_not_said_to_select():
    agent = agent_of(at(0.0, 3, 24, 3), at(0.6, 24, 3, 3))
    assert not agent.inference.broken.differ
    assert agent.contrast.detectable
    assert finding(agent).startswith("llm:local solved the box more often")


def test_shares_are_of_the_trials_that_were_begun():
    trials = [*at(0.0, 5, 15, 0), *at(0.4, 5, 5, 10)]
    found = broken_shares(outcomes(trials), broken_off(trials), generator(1))
    assert [(p, share.count, share.n) for p, share in found.at] == [(0.0, 0, 20), (0.4, 10, 20)]
    assert found.p_value < 0.01
    assert broken_shares(outcomes(trials), broken_off([]), generator(1)) is None


def test_completed_studies_hold_every_trial_once():
    trials = [*at(0.0, 5, 15, 0), *at(0.4, 5, 5, 10)]
    unsolved, solved = completed(outcomes(trials), broken_off(trials))
    assert len(unsolved) == len(solved) == 40
    assert (unsolved.solved.sum(), solved.solved.sum()) == (10, 20)
    assert (unsolved.length <= solved.length).all()


def test_without_broken_trials_nothing_changes():
    trials = [*at(0.0, 9, 21, 0), *at(0.4, 20, 10, 0)]
    counted = outcomes(trials)
    plain, same = infer(counted, generator(1)), infer(counted, generator(1), broken=broken_off(trials))
    assert plain == same
    assert plain.broken is None


def test_calls_that_fail_at_one_p_are_no_effect_of_p():
    """Ninety trials a p, 8 % of calls fail at one: what remains differs in a quarter of studies, and nothing is said."""
    alone, bounded = [], []
    for seed in range(30):
        counted, broken = simulated("broken-trials", generator(seed), Design(trials=30))
        one, *ends = (any_difference(part, generator(seed), 199) for part in (counted, *completed(counted, broken)))
        alone.append(one.p_value < 0.05)
        bounded.append(worst_case_difference(one, *ends).p_value < 0.05)
    assert np.mean(alone) > 0.1
    assert np.mean(bounded) <= 0.05


def test_every_test_holds_over_both_ends():
    rejected = []
    for seed in range(6):
        counted, broken = simulated("broken-trials", generator(seed), breaks=0.08)
        without, bounded = (infer(counted, generator(seed), broken=part) for part in (None, broken))
        for first, second in zip(without.tests, bounded.tests, strict=True):
            if second.p_value is not None:
                assert second.p_value >= first.p_value
        rejected.append([test.rejects for test in bounded.tests])
    assert np.mean(rejected, axis=0).max() <= 0.05 + 2.5 * np.sqrt(0.05 * 0.95 / 6)
