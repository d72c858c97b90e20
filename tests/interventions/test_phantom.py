"""Phantoms: which joint seems to jump, how often, and that nothing else is false."""

import numpy as np
import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.interventions.phantom import Phantom
from lockprobe.studies.running.single import run_trial
from lockprobe.trial.record import STATES, Moment, Percept, Task

TASK = Task(joints=("A", "B", "C"), target="C", budget=20)
TRUTH = Percept(joint="B", outcome="moved", positions=(False, True, False))


def told(p, seed=1, truth=TRUTH, reports=4_000):
    """Whether the position of each joint is false in each report, shape (reports, joints)."""
    rng, past, found = np.random.default_rng(seed), (), []
    for _ in range(reports):
        percept = Phantom(p=p).perceive(truth, past, TASK, rng)
        assert percept.outcome == truth.outcome
        found.append([a != b for a, b in zip(percept.positions, truth.positions, strict=True)])
        past = (Moment(was=truth, told=percept),)
    return np.array(found)


def test_a_share_p_of_reports_has_one_false_position_and_each_other_joint_is_equally_likely():
    false = told(0.4)
    assert set(false.sum(axis=1)) == {0, 1}
    assert false.mean(axis=0) == pytest.approx([0.2, 0, 0.2], abs=0.03)


def test_a_phantom_is_gone_in_the_next_report():
    first, later = Phantom(p=1.0), Phantom(p=0.0)
    phantom = first.perceive(TRUTH, (), TASK, np.random.default_rng(1))
    assert phantom.positions != TRUTH.positions
    assert later.perceive(TRUTH, (Moment(was=TRUTH, told=phantom),), TASK, np.random.default_rng(2)) == TRUTH


def test_phantoms_at_a_smaller_p_are_a_subset_of_those_at_a_larger():
    fewer, more, all_ = (told(p, reports=200) for p in (0.2, 0.5, 1))
    assert (fewer <= more).all()
    assert (more <= all_).all()
    assert (all_.sum(axis=1) == 1).all()


def test_it_hits_the_steps_at_which_a_flip_of_equal_p_lies():
    given = {"agent": "round-robin", "box": "chain-7", "seed": 3, "max_steps": 30, "modality": "symbolic"}
    flipped = run_trial(condition="flip?p=0.4", **given)
    phantom = run_trial(condition="phantom?p=0.4", **given)
    lies = [step.told_falsely for step in flipped.steps[:-1]]
    truth = [step.state for step in phantom.steps[1:]]
    false = [was != step.told_state for was, step in zip(truth, phantom.steps, strict=False)]
    assert false == lies
    assert any(lies)
    assert not any(step.told_falsely for step in phantom.steps)


def test_where_no_outcome_is_told_an_attempt_of_the_joint_that_jumped_is_inferred_falsely():
    trials = [
        run_trial(agent="random", condition="phantom?p=0.5", modality=STATES, trial=trial) for trial in range(1, 21)
    ]
    false = [step.told_falsely for trial in trials for step in trial.steps]
    assert 0.02 < np.mean(false) < 0.25  # one in eight attempts meets the joint that jumped


def test_it_draws_equally_often_whatever_p_is():
    after = set()
    for p in (0.0, 0.3, 1.0):
        rng = np.random.default_rng(1)
        for percept in (Percept(positions=(False,) * 3), TRUTH, Percept(joint="A"), TRUTH):
            Phantom(p=p).perceive(percept, (), TASK, rng)
        after.add(rng.random())
    assert len(after) == 1


def test_the_only_joint_of_a_box_has_no_other():
    alone = Percept(joint="A", outcome="blocked", positions=(False,))
    task = Task(joints=("A",), target="A", budget=2)
    assert Phantom(p=1.0).perceive(alone, (), task, np.random.default_rng(1)) == alone


def test_a_rate_that_is_none_is_named():
    with pytest.raises(BadValue, match=r"^phantom rate p: got 1.2, expected a number from 0 to 1$"):
        Phantom(p=1.2)
