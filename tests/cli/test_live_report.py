"""The report of a run that goes on: when it is written, and that nothing of it disturbs the run."""

import dataclasses
from types import SimpleNamespace

import pytest
from builders import modality_study

from lockprobe.agents.catalogue import resolve
from lockprobe.cli import live_report
from lockprobe.cli.live_report import PAUSE, LiveReport
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.running.observer import Observer
from lockprobe.studies.running.runner import run


class Process:
    """A report that is being written until it is said to be done."""

    begun = ()

    def __init__(self, command, **settings):
        self.command, self.done, self.pid = command, False, 0
        Process.begun += (self,)

    def poll(self):
        return 0 if self.done else None

    def wait(self, timeout=None):
        self.done = True


@pytest.fixture
def clock(monkeypatch):
    now = [0.0]
    Process.begun = ()
    monkeypatch.setattr(live_report, "subprocess", SimpleNamespace(Popen=Process, DEVNULL=None))
    monkeypatch.setattr(live_report.os, "setpriority", lambda *arguments: None)
    monkeypatch.setattr(live_report, "time", SimpleNamespace(monotonic=lambda: now[0]))
    return now


def slow(source):
    return dataclasses.replace(source, engine="network")


def test_it_is_written_while_slow_agents_play_after_pauses_that_double(clock, tmp_path):
    told = []
    live = LiveReport(Observer(), tmp_path, tell=told.append)
    live.agent(resolve("random"), 3)
    clock[0] = 10 * PAUSE
    live.trial(None, None)
    assert not Process.begun  # strategies take a second: their report is the last one
    live.agent(slow(resolve("round-robin")), 3)
    times = []
    for second in range(1, 2000):
        clock[0] = 10 * PAUSE + second
        for process in Process.begun:
            process.done = True
        before = len(Process.begun)
        live.trial(None, None)
        times += [second] * (len(Process.begun) - before)
    assert times == [PAUSE * factor for factor in (1, 2, 4, 8, 16)]
    assert {tuple(process.command[-2:]) for process in Process.begun} == {("report", str(tmp_path))}
    assert told == [tmp_path / "report.html"]


def test_one_is_written_at_a_time_and_waited_for_at_the_end(clock, tmp_path):
    live = LiveReport(Observer(), tmp_path)
    live.agent(slow(resolve("random")), 3)
    for clock[0] in (PAUSE - 1, PAUSE, 1e6):
        live.trial(None, None)
    (only,) = Process.begun
    assert not only.done
    live.end()
    assert only.done


def test_a_run_is_watched_as_before_and_a_machine_that_starts_no_process_goes_on(monkeypatch, tmp_path):
    class Watching(Observer):
        def begin(self, study, journal, owed):
            seen.append(owed)

        def agent(self, source, owed):
            seen.append(source.spec)

        def trial(self, trial, timing):
            seen.append(trial.key)

    def none_left(*arguments, **settings):
        raise OSError

    monkeypatch.setattr(live_report, "subprocess", SimpleNamespace(Popen=none_left, DEVNULL=None))
    small = modality_study(("random",), ("symbolic",), trials=2, max_steps=2)
    seen = []
    with Journal.open(tmp_path, small) as journal:
        run(small, journal, observer=LiveReport(Watching(), tmp_path))
    assert seen == [2, "random", *(plan.key for plan in small.plans("random"))]
