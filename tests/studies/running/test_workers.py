"""Worker processes: a death costs one trial an error, which is owed again; a mistake is said once."""

import os

import pytest

from lockprobe.foundation.errors import Missing, UserMistake
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.running.workers import play_in_workers

AGENTS = """
import os
from lockprobe.trial.record import Decision
class Mortal:
    facts = {}
    async def decide(self, situation, rng):
        if situation.task.target == os.environ["DEADLY"]:
            os._exit(9)
        return Decision(joint=situation.task.joints[len(situation.past) % 4])
"""


@pytest.fixture
def mortal(tmp_path, monkeypatch):
    (tmp_path / "mortals.py").write_text(AGENTS)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")]))
    monkeypatch.syspath_prepend(tmp_path)
    planned = study(StudyOptions(agent=["python:mortals:Mortal"], p=[0], trials=6, repetitions=1, seed=2))
    return list(planned.plans("python:mortals:Mortal"))


def played(plans, workers):
    trials, steps = [], []
    play_in_workers(plans, workers, lambda key, step: steps.append(key), lambda trial, timing: trials.append(trial))
    return trials, steps


def targets(plans):
    from lockprobe.foundation.errors import ModelFault
    from lockprobe.trial.loop import broken

    return {plan.key: broken(plan, ModelFault("")).labels[0] for plan in plans}


def test_every_plan_is_played_once_by_several_workers(mortal, monkeypatch):
    monkeypatch.setenv("DEADLY", "none")
    trials, steps = played(mortal, 2)
    assert sorted(trial.key for trial in trials) == sorted(plan.key for plan in mortal)
    assert all(trial.solved for trial in trials)
    assert len(steps) == sum(len(trial.steps) for trial in trials)


def test_a_dead_worker_costs_its_trial_an_error_and_is_replaced(mortal, monkeypatch):
    labels = targets(mortal)
    deadly = next(label for label in "ABCD" if list(labels.values()).count(label) == 1)
    monkeypatch.setenv("DEADLY", deadly)
    trials, _ = played(mortal, 2)
    assert len(trials) == len(mortal)
    dead = [trial for trial in trials if trial.ending == "error"]
    assert [labels[trial.key] for trial in dead] == [deadly]
    assert dead[0].owed_again
    assert dead[0].error.boundary == "plant"  # an agent that is asked here takes no processor
    assert dead[0].error.message == "the worker process of python:mortals:Mortal died (exit status 9)"


def test_workers_that_keep_dying_stop_the_run(mortal, monkeypatch):
    label = targets(mortal)[mortal[0].key]
    monkeypatch.setenv("DEADLY", label)
    with pytest.raises(Missing, match=r"died \(exit status 9\), 3 times with no finished trial in between"):
        played([mortal[0]] * 5, 1)


def test_an_agent_that_cannot_be_had_is_a_users_mistake(mortal):
    plans = list(study(StudyOptions(agent=["python:nowhere:X"], p=[0], trials=2)).plans("python:nowhere:X"))
    with pytest.raises(UserMistake, match="agent: got 'python:nowhere:X', expected python:module:Name"):
        played(plans, 1)
