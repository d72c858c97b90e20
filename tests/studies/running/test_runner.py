"""The issue's figures on whole studies, through runner and journal."""

import asyncio
import re
from collections import Counter
from dataclasses import replace

import forked
import pytest
from provider_server import Manner, here
from stored import sql

from lockprobe.agents.catalogue import resolve
from lockprobe.agents.llm.settings import Access
from lockprobe.foundation.errors import AgentsGivenUp, SettingsChanged, UserMistake
from lockprobe.foundation.plugins import allow
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load
from lockprobe.studies.running import executor, runner
from lockprobe.studies.running.runner import Limits, run


def played(directory, **settings):
    planned = study(StudyOptions(**({"repetitions": 1} | settings)))
    with Journal.open(directory, planned) as journal:
        run(planned, journal)
    return load(directory)


AGENT = """
from lockprobe.trial.record import Decision
class Mine:
    facts = {"model": "a"}
    async def decide(self, situation, rng):
        return Decision(joint=situation.task.joints[len(situation.past) % 4])
"""


def test_two_models_are_not_mixed_under_one_name(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "mine_a.py").write_text(AGENT)
    played(tmp_path / "d", agent=["python:mine_a:Mine"], p=[0], trials=2)
    sql(tmp_path / "d", "delete from trial where id > 1")
    monkeypatch.setattr("mine_a.Mine.facts", {"model": "b"})
    with pytest.raises(SettingsChanged, match=r"python:mine_a:Mine, model is 'a' there, 'b' asked"):
        played(tmp_path / "d", agent=["python:mine_a:Mine"], p=[0], trials=2)
    assert len(load(tmp_path / "d")) == 1


def test_hosted_trials_go_side_by_side_on_so_many_connections_and_every_call_is_made_once(tmp_path):
    planned = study("flips", agent="llm:openai-api/fake/model", p=[0], trials=9, repetitions=1)
    with here(manner=Manner(median=0.003)) as server:
        trials = runner.run_study(planned, tmp_path, limits=Limits(access=Access(connections=3)))
    assert [trial.ending for trial in trials] == ["solved"] * 9
    assert server.peak == 3
    assert server.arrived.total() == sum(len(trial.steps) for trial in trials) == len(list(read_calls(tmp_path)))


AGENTS = """
class Raises:
    facts = {}
    async def decide(self, situation, rng):
        raise RuntimeError("of no use")

class Nowhere:
    facts = {}
    async def decide(self, situation, rng):
        from lockprobe.trial.record import Decision
        return Decision(joint="lid")

class Unclosed:
    facts = {}
    async def decide(self, situation, rng):
        from lockprobe.trial.record import Decision
        return Decision(joint=situation.task.joints[0])
    async def aclose(self):
        raise RuntimeError("stays open")
"""


def test_agents_that_cannot_go_on_are_given_up_and_the_others_play(tmp_path, monkeypatch):
    """One raises in every trial, one at its end; weights that no engine can load end in a worker process."""
    (tmp_path / "dying.py").write_text(AGENTS, "utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    allow("python:dying:Raises", "python:dying:Unclosed", "python:dying:Nowhere")

    def in_processes(pool, begin, jobs):
        raise UserMistake("round-robin cannot be loaded")

    def elsewhere(spec, access):
        source = resolve(spec, access)
        return replace(source, engine="process") if spec == "round-robin" else source

    monkeypatch.setattr(runner, "resolve", elsewhere)
    monkeypatch.setattr(executor.Processes, "each", in_processes)
    agents = ["Ours=python:dying:Raises", "python:dying:Unclosed", "round-robin", "python:dying:Nowhere", "random"]
    with pytest.raises(AgentsGivenUp) as end:
        played(tmp_path / "s", agent=agents, trials=12, p=[0], repetitions=1)
    assert list(end.value.why) == ["python:dying:Raises", agents[1], agents[3], agents[2]]
    assert "Ours broke 10 trials in a row (model: in the agent (dying.py, line 5): RuntimeError: of no use)" in str(
        end.value
    )
    assert "stays open" in str(end.value)
    assert "round-robin cannot be loaded" in str(end.value)
    ended = Counter(trial.agent for trial in load(tmp_path / "s") if not trial.owed_again)
    assert ended == {"python:dying:Unclosed": 12, "python:dying:Nowhere": 10, "random": 12}
    assert re.search(r"Nowhere broke 10 trials in a row \(reply: .*'lid'.*\)", str(end.value))


def in_event_loop(call):
    """What a call gives in a thread that runs an event loop, as a notebook's does."""

    async def cell():
        return call()

    loop = asyncio.new_event_loop()  # asyncio.run would take Ctrl-C itself
    try:
        return loop.run_until_complete(cell())
    finally:
        loop.close()


INTERRUPTED = """
import asyncio, os, signal, sys, time
from lockprobe.studies.running import executor, runner
from lockprobe.studies.options.studyfile import study

planned = study("flips", agent=["random"], p=[0, 0.4], trials=5, repetitions=1)
step, seen = runner._Stoppable.step, set()

def interrupted(self, key, at):
    once = key not in seen
    seen.add(key)
    if len(seen) == 5 and once:
        os.kill(os.getpid(), signal.SIGINT)
        until = time.monotonic() + 5
        while not self.stopped and time.monotonic() < until:
            time.sleep(0.01)
    step(self, key, at)

async def cell():
    runner.run_study(planned, sys.argv[1])

runner._Stoppable.step = interrupted
try:
    asyncio.new_event_loop().run_until_complete(cell())  # asyncio.run handles Ctrl-C itself
except KeyboardInterrupt:
    print("interrupted")
"""
"""In a process of its own: an interrupt that came late would end the tests."""


def test_a_notebook_cell_that_is_interrupted_keeps_what_was_finished_and_is_resumed(tmp_path):
    done = forked.run([tmp_path / "cell"], script=INTERRUPTED)
    assert done.stdout == "interrupted\n"
    planned = study(StudyOptions(agent=["random"], p=[0, 0.4], trials=5, repetitions=1))
    assert len(load(tmp_path / "cell")) == 4
    assert in_event_loop(lambda: runner.run_study(planned, tmp_path / "cell")) == runner.run_study(
        planned, tmp_path / "script"
    )
