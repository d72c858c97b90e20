"""A hand that slips does as a lapse of the same rate, and is truthfully reported."""

from collections import Counter

from scipy.stats import binomtest

from lockprobe.foundation.seeds import trial_stream
from lockprobe.interventions.tremble import Tremble
from lockprobe.simulation.exact.propagation import propagate
from lockprobe.studies.running.single import run_trial
from lockprobe.trial.record import Task


def test_another_joint_is_attempted_and_truthfully_reported():
    trial = run_trial(agent="random", condition="tremble?p=1 + symbolic", box="chain-7")
    label = dict(zip(trial.joints, trial.labels, strict=True))
    for step in trial.steps:
        assert step.chosen not in (None, step.joint)
        assert label[step.chosen] == step.decision.joint
        assert step.told.startswith(label[step.joint])
        assert step.told_moved == step.moved


def test_every_other_joint_is_equally_likely():
    task, rng = Task(joints=("A", "B", "C", "D"), target="D", budget=20), trial_stream(1, 1, 1, "x")
    found = Counter(Tremble(p=1).act("B", (), task, rng) for _ in range(3000))
    assert set(found) == {"A", "C", "D"}
    assert all(binomtest(n, 3000, 1 / 3).pvalue > 0.001 for n in found.values())


def test_it_is_a_lapse_of_the_agent_s_hand():
    """A lapse takes any of four joints, a slip any of the three others: a slip of 0.3 is a lapse of 0.4."""
    exact = propagate("human-inspired?lapse=0.4", p=0.0).success
    trials = [run_trial(agent="human-inspired", condition="tremble?p=0.3", trial=t) for t in range(1, 301)]
    assert binomtest(sum(trial.solved for trial in trials), 300, exact).pvalue > 0.001
