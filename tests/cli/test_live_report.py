"""The report of a run that goes on: when it is written, and that nothing of it disturbs the run."""

from types import SimpleNamespace

import pytest

from lockprobe.cli import live_report
from lockprobe.cli.live_report import PAUSE, LiveReport


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


def test_it_is_written_while_slow_agents_play_after_pauses_that_double(clock, tmp_path):
    live, told, times = LiveReport(tmp_path), [], []
    clock[0] = 10 * PAUSE
    assert live.renew() is None
    assert not Process.begun  # strategies take a second: their report is the last one
    live.begin()
    for second in range(1, 2000):
        clock[0] = 10 * PAUSE + second
        for process in Process.begun:
            process.done = True
        before = len(Process.begun)
        told += [page] if (page := live.renew()) else []
        times += [second] * (len(Process.begun) - before)
    assert times == [PAUSE * factor for factor in (1, 2, 4, 8, 16)]
    assert {tuple(process.command[-2:]) for process in Process.begun} == {("report", str(tmp_path))}
    assert told == [tmp_path / "report.html"]


def test_one_is_written_at_a_time_and_waited_for_at_the_end(clock, tmp_path):
    live = LiveReport(tmp_path)
    live.begin()
    for clock[0] in (PAUSE - 1, PAUSE, 1e6):
        live.renew()
    (only,) = Process.begun
    assert not only.done
    live.end()
    assert only.done


def test_a_machine_that_starts_no_process_goes_on(clock, monkeypatch, tmp_path):
    def none_left(*arguments, **settings):
        raise OSError

    monkeypatch.setattr(live_report, "subprocess", SimpleNamespace(Popen=none_left, DEVNULL=None))
    live = LiveReport(tmp_path)
    live.begin()
    clock[0] = 2 * PAUSE
    assert live.renew() is None
    live.end()
