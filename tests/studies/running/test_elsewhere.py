"""Trials that are played in other processes and on a cluster: the same records, and a loss costs one trial."""

import os
from contextlib import contextmanager
from dataclasses import replace

import pytest
import strangers

from lockprobe.agents.catalogue import resolve
from lockprobe.foundation.workers import Lost
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load
from lockprobe.studies.running import runner
from lockprobe.studies.running.executor import Observer, can_travel
from lockprobe.studies.running.runner import Limits, run
from lockprobe.trial.trial_json import trial_to_json

SMALL = {"condition": ["tremble?p=0.2", "flip?p=0.4 + tremble?p=0.2"], "trials": 3, "repetitions": 1}
"""Trials that the kernel does not know."""


class Backwards:
    """A cluster in this process: the last job is done first. Some are lost."""

    def __init__(self, lost=()):
        self.lost, self.asked = set(lost), []

    def processors(self):
        return 1

    def each(self, begin, jobs):
        work = begin()
        for number, job in reversed(list(enumerate(jobs))):
            self.asked.append(job.key)
            yield job, Lost("ActorDiedError") if number in self.lost else work(job)


class Seen(Observer):
    def __init__(self):
        self.steps = []

    def step(self, key, step):
        self.steps.append((key, step))


@contextmanager
def played(directory, planned, cluster=None, observer=None, workers=1):
    with Journal.open(directory, planned) as journal:
        run(planned, journal, limits=Limits(cluster=cluster, workers=workers), observer=observer)
        yield journal


def lines(directory):
    return sorted(trial_to_json(trial) for trial in load(directory))


def pictures(directory):
    return {path.name: path.read_bytes() for path in (directory / "pictures").iterdir()}


def test_records_and_pictures_are_those_of_one_process_on_a_cluster_too(tmp_path):
    small, shown = "fast-twin?width=64&height=64", ["symbolic", "rgb"]
    planned = study("modalities", agent=["viewer"], plant=small, modality=shown, trials=1, repetitions=1, max_steps=2)
    cluster, seen = Backwards(), Seen()
    with played(tmp_path / "here", planned), played(tmp_path / "there", planned, cluster, seen):
        assert len(cluster.asked) == planned.size
    told = [(trial.key, step) for trial in load(tmp_path / "here") for step in trial.steps]
    assert lines(tmp_path / "there") == lines(tmp_path / "here")
    assert pictures(tmp_path / "there") == pictures(tmp_path / "here") != {}
    assert sorted(seen.steps, key=repr) == sorted(told, key=repr)  # each once


MORTAL = """
import os
from lockprobe.trial.record import Decision
class Mortal:
    facts = {}
    async def decide(self, situation, rng):
        if situation.task.target == "A":
            os._exit(9)
        return Decision(joint=situation.task.joints[len(situation.past) % 4])
"""


def test_an_agent_that_ends_its_process_costs_its_trials_an_error_and_they_are_owed(tmp_path, monkeypatch):
    (tmp_path / "mortals.py").write_text(MORTAL)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(runner, "resolve", lambda *asked: replace(resolve(*asked), engine="process"))
    planned = study("flips", agent=["python:mortals:Mortal"], p=[0], trials=6, repetitions=1, seed=2)
    with played(tmp_path / "S", planned, workers=2):
        pass
    broken = [trial for trial in load(tmp_path / "S") if trial.error is not None]
    assert 0 < len(broken) < planned.size
    assert {trial.labels[trial.joints.index(trial.target)] for trial in broken} == {"A"}
    assert {(one.error.boundary, one.error.message, one.owed_again) for one in broken} == {
        ("model", "python:mortals:Mortal lost its worker: a worker process died, exit status 9", True)
    }


def test_what_was_lost_is_owed_and_played_by_the_same_command(tmp_path):
    planned = study("flips", agent=["random"], **SMALL)
    with played(tmp_path, planned, Backwards(lost=[2])) as journal:
        (broken,) = [trial for trial in journal.trials.values() if trial.ending == "error"]
        error = journal.read(broken.key).error
        assert (error.boundary, error.message) == ("plant", "random lost its worker: ActorDiedError")
        assert journal.owes(broken.key)
    with played(tmp_path, planned, again := Backwards()):
        assert again.asked == [broken.key]
    assert all(trial.error is None for trial in load(tmp_path))


@pytest.mark.parametrize(
    ("asked", "travels"),
    [
        ({"agent": ["human-inspired"]}, True),
        ({"agent": ["llm:local"]}, True),
        ({"agent": ["viewer"], "plant": "fast-twin?looks=varied", "modality": ["rgb"]}, True),
        ({"agent": ["random"], "condition": ["flip?p=0.4", "tremble?p=0.1"]}, True),
        ({"agent": ["llm:mockllm/model"]}, False),  # each call is in this study's log and budget
        ({"agent": ["python:strange:First"]}, False),  # it may pay, or is not there
        ({"agent": ["random"], "plant": "python:strange:Plain"}, False),  # it may move
        ({"agent": ["random"], "plant": "rig?rung=scripted"}, False),
        ({"agent": ["random"], "condition": ["python:strange:Hush?steps=1"]}, False),
    ],
)
def test_what_may_pay_or_move_stays_here(tmp_path, monkeypatch, asked, travels):
    strangers.install(tmp_path, monkeypatch)
    planned = study("flips", **asked)
    assert can_travel(planned, resolve(planned.agents[0])) == travels
