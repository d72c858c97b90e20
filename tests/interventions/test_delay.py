"""A late report says what was true some attempts ago."""

import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.interventions.delay import Delay
from lockprobe.studies.running.single import run_trial


@pytest.mark.parametrize("lag", [1, 2, 5])
def test_every_report_is_the_truth_of_some_attempts_ago(lag):
    trial = run_trial(agent="round-robin", condition=f"delay?lag={lag} + symbolic", box="chain-7")
    label = dict(zip(trial.joints, trial.labels, strict=True))
    moved = {True: "moved", False: "did not move"}
    for now, then in zip(trial.steps[lag:], trial.steps, strict=False):
        assert now.told.startswith(f"{label[then.joint]} {moved[then.moved]}.")
        assert now.told_moved == then.moved
    assert {(step.told_moved, step.told) for step in trial.steps[:lag]} == {(None, "")}


def test_it_forgets_what_was_before_it_and_keeps_what_comes_after():
    plain, before, after = (
        run_trial(agent="round-robin", condition=spec, modality="symbolic", box="chain-7")
        for spec in ("delay?lag=1", "flip?p=1 + delay?lag=1", "delay?lag=1 + flip?p=1")
    )
    assert [step.told for step in before.steps] == [step.told for step in plain.steps]
    told = [step.told_moved for step in plain.steps[1:]]
    assert [step.told_moved for step in after.steps[1:]] == [not moved for moved in told]


def test_it_is_not_early():
    with pytest.raises(BadValue, match="lag: got -1, expected a whole number from 0"):
        Delay(lag=-1)
