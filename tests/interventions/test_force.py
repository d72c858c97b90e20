"""One step is the experimenter's."""

import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.interventions.force import Force
from lockprobe.studies.running.single import run_trial


def test_one_step_is_drawn_and_all_others_are_the_agent_s():
    trial = run_trial(agent="round-robin", condition="force?at=3", box="chain-7", seed=2)
    assert [step.step for step in trial.steps if step.chosen is not None] == [3]
    plain = run_trial(agent="round-robin", box="chain-7", seed=2)
    assert trial.actions[:2] == plain.actions[:2]
    assert trial.steps[2].chosen == plain.actions[2]


def test_mistakes():
    with pytest.raises(BadValue, match="at: got -1, expected a step from 1, or 0 for none"):
        Force(at=-1)
    with pytest.raises(BadValue, match="joint: got 'door', expected one of C, A, D, B"):
        run_trial(agent="round-robin", condition="force?at=2&joint=door", modality="symbolic")
