"""Trials that are played elsewhere and written down here."""

from contextlib import contextmanager

import pytest

from lockprobe.agents.catalogue import resolve
from lockprobe.foundation.cluster import Lost
from lockprobe.foundation.errors import Missing
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load
from lockprobe.studies.records.trial_rows import read_timings
from lockprobe.studies.running.cluster_trials import can_travel
from lockprobe.studies.running.observer import Observer
from lockprobe.studies.running.runner import Limits, run
from lockprobe.trial.trial_json import trial_to_json

SMALL = {"p": [0, 0.4], "trials": 3, "repetitions": 1}


class Backwards:
    """A cluster in this process: the last job is done first. Some are lost."""

    def __init__(self, lost=()):
        self.lost, self.asked = set(lost), []

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
def played(directory, planned, cluster=None, observer=None):
    with Journal.open(directory, planned) as journal:
        run(planned, journal, limits=Limits(cluster=cluster), observer=observer)
        yield journal


def lines(directory):
    return sorted(trial_to_json(trial) for trial in load(directory))


def pictures(directory):
    return {path.name: path.read_bytes() for path in (directory / "pictures").iterdir()}


def test_records_and_pictures_are_those_of_one_process(tmp_path):
    small = "fast-twin?width=320&height=240"
    planned = study("modalities", agent=["viewer"], plant=small, p=[0.4], trials=1, repetitions=1, max_steps=2)
    with played(tmp_path / "here", planned), played(tmp_path / "there", planned, cluster := Backwards()):
        assert len(cluster.asked) == planned.size
    assert lines(tmp_path / "there") == lines(tmp_path / "here")
    assert pictures(tmp_path / "there") == pictures(tmp_path / "here") != {}
    assert all(timing.cpu for timing in read_timings(tmp_path / "there"))


def test_every_step_is_reported_when_its_trial_arrives(tmp_path):
    with played(tmp_path, study("flips", agent=["random"], **SMALL), Backwards(), seen := Seen()):
        pass
    assert seen.steps == [(trial.key, step) for trial in load(tmp_path) for step in trial.steps]


def test_what_was_lost_is_owed_and_played_by_the_same_command(tmp_path):
    planned = study("flips", agent=["random"], **SMALL)
    with played(tmp_path, planned, Backwards(lost=[2])) as journal:
        (broken,) = [trial for trial in journal.trials.values() if trial.ending == "error"]
        assert broken.error.boundary == "plant"
        assert broken.error.message == "the workers of random on the cluster were lost (ActorDiedError)"
        assert journal.owes(broken.key)
    with played(tmp_path, planned, again := Backwards()):
        assert again.asked == [broken.key]
    assert all(trial.error is None for trial in load(tmp_path))


def test_a_study_that_stops_when_it_is_decided_decides_the_same_there(tmp_path):
    planned = study("flips", agent=["round-robin"], box="chain-3", p=[0, 0.4], until="±40", most=25)
    with played(tmp_path / "here", planned), played(tmp_path / "there", planned, cluster := Backwards(lost=[2])):
        assert len(cluster.asked) == len(load(tmp_path / "here")) + 2  # one is lost before each look
    assert lines(tmp_path / "there") == lines(tmp_path / "here")
    assert len(lines(tmp_path / "there")) == 20 < planned.size


def test_nothing_but_losses_ends_the_run(tmp_path):
    planned = study("flips", agent=["random"], p=[0], trials=12, repetitions=1)
    with (
        pytest.raises(Missing, match="random broke 10 trials in a row"),
        played(tmp_path, planned, Backwards(range(12))),
    ):
        pass


@pytest.fixture
def mine(tmp_path, monkeypatch):
    """A module of a user: an agent that may pay, and an intervention."""
    (tmp_path / "of_mine.py").write_text(
        "from lockprobe.interventions.drop import Drop\n"
        "from lockprobe.trial.record import Decision\n"
        "class Silence(Drop):\n    name = 'silence'\n"
        "class Mine:\n    facts = {}\n    async def decide(self, situation, rng):\n"
        "        return Decision(joint=situation.task.labels[0])\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path))


@pytest.mark.parametrize(
    ("asked", "travels"),
    [
        ({"agent": ["human-inspired"]}, True),
        ({"agent": ["llm:local"]}, True),
        ({"agent": ["viewer"], "plant": "fast-twin?looks=varied", "modality": ["rgb"]}, True),
        ({"agent": ["random"], "condition": ["flip?p=0.4", "tremble?p=0.1"]}, True),
        ({"agent": ["llm:mockllm/model"]}, False),  # each call is in this study's log and budget
        ({"agent": ["python:of_mine:Mine"]}, False),  # it may pay, or is not there
        ({"agent": ["random"], "plant": "python:of_mine:Rig"}, False),  # it may move
        ({"agent": ["random"], "plant": "rig?rung=scripted"}, False),
        ({"agent": ["random"], "condition": ["python:of_mine:Silence?p=0.5"]}, False),
    ],
)
def test_what_may_pay_or_move_stays_here(mine, asked, travels):
    planned = study("flips", **asked)
    assert can_travel(planned, resolve(planned.agents[0])) == travels


def test_an_agent_that_may_pay_is_played_here(mine, tmp_path):
    planned = study("flips", agent=["python:of_mine:Mine"], **SMALL)
    with played(tmp_path / "S", planned, cluster := Backwards()) as journal:
        assert len(journal.trials) == planned.size
    assert cluster.asked == []
