"""Trials made for tests are such as studies write."""

import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.interventions.tremble import Tremble
from lockprobe.studies.running.single import run_trial
from lockprobe.testing import ScriptedAgent, make_trial, play_trials
from lockprobe.testing.records import check_facts
from lockprobe.trial.trial_json import trial_from_json, trial_to_json


def test_a_trial_attempts_what_it_is_told_as_the_box_reacts():
    trial = make_trial([3, 3, 0, 3, 2, 1, 0], false_at=[3], claims=[None, "moved", "blocked"])
    assert [step.moved for step in trial.steps] == [True, True, False, True, True, True, True]
    assert [step.told_falsely for step in trial.steps] == [False, False, True, False, False, False, False]
    assert [step.decision.claimed for step in trial.steps[:4]] == [None, "moved", "blocked", None]
    assert (trial.solved, trial.budget, trial.labels) == (True, 7, tuple("ABCD"))
    assert trial_from_json(trial_to_json(trial)) == trial


def test_it_ends_with_its_list_or_breaks():
    assert (make_trial([0, 1]).ending, make_trial([3, 2, 1, 0, 0]).actions[-1]) == ("budget", "revolute-left")
    broken = make_trial([0, 1], broken=True)
    assert (broken.ending, broken.error.boundary, len(broken.steps)) == ("error", "model", 2)
    assert make_trial([], broken=True).steps == ()
    slipping = make_trial([0] * 9, box="fork", condition=[Tremble(p=1)])
    assert slipping.box == "fork"
    assert all(step.chosen == "revolute-left" for step in slipping.steps)


def test_trials_that_are_played_have_luck_of_their_own():
    three = play_trials("random", 3, condition="drop?p=0.5")
    assert three == [run_trial(agent="random", trial=n, condition="drop?p=0.5") for n in (1, 2, 3)]
    assert len({trial.actions for trial in three}) == 3


def test_a_script_begins_anew_and_has_a_joint():
    assert (
        run_trial(agent=ScriptedAgent(joints=(0, 1)), shuffle="never", max_steps=5).actions[::2]
        == ("revolute-left",) * 3
    )
    with pytest.raises(BadValue, match="^joints: got \\(\\), expected at least one place"):
        ScriptedAgent(joints=())


@pytest.mark.parametrize("facts", [[], {"a": (1, 2)}, {"a": float("nan")}, {1: "x"}])
def test_facts_that_do_not_survive(facts):
    check_facts({"a": 1, "b": None, "c": True, "d": 0.5, "e": ""}, "one")
    with pytest.raises(AssertionError, match="of one"):
        check_facts(facts, "one")
