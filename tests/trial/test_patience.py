"""An agent of one's own that hangs ends its trial, and not the study: it is said which, for how long, and where."""

import asyncio
import os
import re

import pytest

from lockprobe import run_trial
from lockprobe.foundation.plugins import allow
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.running.executor import Limits
from lockprobe.studies.running.runner import run_study
from lockprobe.trial import patience

AGENTS = """\
import asyncio, time
from lockprobe.plants.symbolic import SymbolicPlant
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
    seconds = 0.6

class Dead(Sleeps):
    seconds = 600

class Box(SymbolicPlant):
    def __init__(self, box, labels, rng):
        super().__init__(box)
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
    allow("python:hangs:Box", *(f"python:hangs:{name}" for name in ("Loops", "Awaits", "Sleeps", "Dead")))


@pytest.mark.parametrize(("name", "line", "step"), [("Loops", "sum(", 3), ("Awaits", "Event", 1)])
def test_what_loops_or_awaits_for_ever_ends_its_trial_in_a_notebook_too(name, line, step):
    async def cell():
        return run_trial(agent=f"python:hangs:{name}")

    trial = asyncio.run(cell())
    assert (trial.error.boundary, trial.error.step, trial.owed_again) == ("model", step, True)
    assert re.match(hangs(name, line), trial.error.message)


def test_a_call_that_does_not_come_back_is_named_while_it_hangs(capsys):
    assert run_trial(agent="python:hangs:Sleeps").error.boundary == "model"
    (line,) = capsys.readouterr().err.splitlines()
    assert re.match("lockprobe: " + hangs("Sleeps", "time.sleep", r"0\.[2-6]\d*"), line)
    assert line.endswith("nothing finished is lost by Ctrl-C, twice if need be")


def test_a_worker_in_which_an_agent_hangs_is_replaced(tmp_path):
    options = StudyOptions(agent=["python:hangs:Dead"], plant="python:hangs:Box", p=[0], trials=1, repetitions=1)
    (trial,) = run_study(study(options), tmp_path / "s", limits=Limits(workers=2))
    assert trial.error.boundary == "model"
    assert re.match(hangs("Dead", "time.sleep", r"[\d.]+"), trial.error.message)
