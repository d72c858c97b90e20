"""A report that is lost says nothing, and is lost at every larger dose too."""

import itertools

from lockprobe.studies.running.single import run_trial


def lost(p, seed=1):
    trial = run_trial(agent="round-robin", condition=f"drop?p={p}", seed=seed, box="chain-7", max_steps=30)
    return [step.step for step in trial.steps if step.told_moved is None]


def test_nothing_is_told_of_an_attempt_whose_report_is_lost():
    trial = run_trial(agent="random", condition="drop?p=1", box="chain-7")
    assert {(step.told_moved, step.told_state, step.told) for step in trial.steps} == {(None, None, "")}
    assert {step.decision.claimed for step in trial.steps} == {None}
    assert trial.opening  # the first look is no report


def test_what_is_lost_at_a_smaller_dose_is_lost_at_a_larger_one():
    found = [set(lost(p)) for p in (0.0, 0.3, 0.7, 1.0)]
    assert all(few <= many for few, many in itertools.pairwise(found))
    assert [len(steps) for steps in found][0::3] == [0, 30]


def test_a_strategy_goes_on_with_what_it_knows():
    """It learns nothing of an attempt that was not reported: it tries the target again and again."""
    trial = run_trial(agent="human-inspired", condition="drop?p=1")
    assert set(trial.actions) == {trial.target}


def test_an_attempt_that_was_not_reported_cannot_be_misread():
    from lockprobe.statistics.misinterpretation import trial_claims

    trial = run_trial(agent="human-inspired", condition="drop?p=0.5", seed=3)
    told = sum(step.told_moved is not None for step in trial.steps[:-1])
    assert len(trial_claims(trial).claims) == told < len(trial.steps) - 1
    assert trial_claims(trial).false_reports == 0
    assert not trial.ordinary
