"""An agent of one's own that hangs ends its trial, and not the study: it is said which, for how long, and where."""

import asyncio
import os
import re
from dataclasses import replace

import pytest

from lockprobe.foundation.plugins import allow
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load
from lockprobe.studies.running.executor import Limits
from lockprobe.studies.running.runner import run, run_study
from lockprobe.trial import patience

AGENTS = """\
import asyncio, time
from lockprobe.trial import patience
from lockprobe.trial.record import Decision

patience._LOOK = 0.05

class Loops:
    facts, step_seconds = {}, 0.1
    async def decide(self, situation, rng):
        if len(situation.past) < 2:
            return Decision(joint=situation.task.joints[0])
        while True:
            try:
                for _ in range(999): sum(range(999))
            except Exception:
                pass

class Awaits(Loops):
    async def decide(self, situation, rng):
        await asyncio.Event().wait()

class Sleeps(Loops):
    async def decide(self, situation, rng):
        time.sleep(self.seconds)
        return Decision(joint=situation.task.joints[0])
    seconds = 0.8

class Dead(Sleeps):
    seconds = 600
"""


def hangs(name, line, seconds="0.1"):
    """What is said of an agent that hangs in this line."""
    number = next(i for i, one in enumerate(AGENTS.splitlines(), 1) if line in one)
    return rf"python:hangs:{name} has been deciding for {seconds} s in hangs.py, line {number} \(its class may set"


@pytest.fixture(autouse=True)
def agents(tmp_path, monkeypatch):
    (tmp_path / "hangs.py").write_text(AGENTS)
    monkeypatch.setattr(patience, "_LOOK", 0.05)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")]))
    monkeypatch.syspath_prepend(tmp_path)
    allow(*(f"python:hangs:{name}" for name in ("Loops", "Awaits", "Sleeps", "Dead")))


def planned(*names):
    agents = [f"python:hangs:{name}" for name in names]
    return study(StudyOptions(agent=[*agents, "random"], p=[0], trials=2, repetitions=1))


def test_what_loops_or_awaits_for_ever_ends_its_trial_in_a_notebook_too(tmp_path):
    async def cell():
        return run_study(planned("Loops", "Awaits"), tmp_path / "s")

    trials = asyncio.run(cell())
    for trial, step, said in zip(
        trials[:4], (3, 3, 1, 1), (*[hangs("Loops", "sum(")] * 2, *[hangs("Awaits", "Event")] * 2), strict=True
    ):
        assert (trial.error.boundary, trial.error.step) == ("model", step)
        assert re.match(said, trial.error.message)
    assert all(trial.owed_again for trial in trials[:4])
    assert not any(trial.error for trial in trials[4:])


def test_a_call_that_does_not_come_back_is_named_while_it_hangs(tmp_path, capsys):
    trials = run_study(planned("Sleeps"), tmp_path / "s")
    assert [trial.error.boundary for trial in trials[:2]] == ["model", "model"]
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 2
    assert re.match("lockprobe: " + hangs("Sleeps", "time.sleep", r"0\.[2-7]\d*"), lines[0])
    assert lines[0].endswith("nothing finished is lost by Ctrl-C, twice if need be")


def test_a_worker_in_which_an_agent_hangs_is_replaced(tmp_path):
    dead = replace(planned("Dead"), plant="fast-twin", agents=("python:hangs:Dead",), trials=1)
    with Journal.open(tmp_path / "s", dead) as journal:
        run(dead, journal, limits=Limits(workers=2))
    trials = load(tmp_path / "s")
    assert [trial.error.boundary for trial in trials] == ["model"]
    assert all(re.match(hangs("Dead", "time.sleep", r"[\d.]+"), one.error.message) for one in trials)
