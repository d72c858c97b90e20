"""Exact effects of one lie: those of forks that are played, and of mixtures."""

import pytest
from scipy.stats import binomtest

from lockprobe import propagate, run_trial
from lockprobe.foundation.errors import BadValue
from lockprobe.simulation.exact.excursions import lie_effects


def test_the_first_lie_in_a_truthful_world_is_that_of_forks():
    """Trials with one lie at step 8, and without: they differ after it alone, and as often as is exact."""
    asked, trials = {"agent": "cognitive:insistent", "max_steps": 14}, range(1, 301)
    found = lie_effects(**asked)
    truth = [run_trial(**asked, trial=i) for i in trials]
    lie = [run_trial(**asked, condition="flip?p=1&at=8", trial=i) for i in trials]
    assert all(a.actions[:8] == b.actions[:8] for a, b in zip(truth, lie, strict=True))
    running = [(a, b) for a, b in zip(truth, lie, strict=True) if len(a.steps) > 8]
    assert binomtest(len(running), 300, found.running[7]).pvalue > 0.001
    exact = propagate(**asked, condition="flip?p=1&at=8").success
    assert binomtest(sum(trial.solved for trial in lie), 300, exact).pvalue > 0.001
    assert found.by_step[7] == pytest.approx((exact - propagate(**asked).success) / found.running[7])


def test_blind_agents_are_not_changed():
    assert lie_effects("random", p=0.3, max_steps=8).by_step == pytest.approx([0] * 7, abs=1e-12)


def test_a_trial_of_one_step_has_no_future():
    with pytest.raises(BadValue, match="at least 2"):
        lie_effects(max_steps=1)
