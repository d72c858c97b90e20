"""The report of a study that is being played: when it is written again, and when that ends."""

import json

import pytest
from builders import play_study, small_study, write_study
from stored import sql

from lockprobe.cli import report as command
from lockprobe.cli.watch_report import PAUSE, owed_trials, watch_report
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load
from lockprobe.studies.records.trial_rows import Timing
from lockprobe.studies.running.runner import run_study

STUDY = small_study(agents=("random",), p=(0.0,), repetitions=1, trials=4)
TRIALS = play_study(STUDY)


def append(directory, trials):
    with Journal.open(directory, STUDY) as journal:
        for trial in trials:
            journal.append(trial, Timing(key=trial.key, seconds=1.0, steps=len(trial.steps)))


class Run:
    """A study of which some trials are finished during each of these waits, and a report that takes so long."""

    def __init__(self, directory, *played, takes=0.0):
        self.directory, self.played, self.takes = directory, list(played), takes
        self.now, self.reports, self.during = 0.0, [], {}

    def write(self):
        self.reports.append((self.now, len(load(self.directory))))
        append(self.directory, self.during.pop(len(self.reports), ()))
        self.now += self.takes

    def sleep(self, seconds):
        self.now += seconds
        if not self.played:
            raise KeyboardInterrupt
        append(self.directory, self.played.pop(0))

    def watch(self):
        watch_report(self.directory, self.write, sleep=self.sleep, clock=lambda: self.now)


def test_a_finished_study_is_reported_once(tmp_path):
    run = Run(write_study(tmp_path / "study", STUDY, TRIALS))
    run.watch()
    assert run.reports == [(0.0, 4)]


def test_a_study_that_has_stopped_is_reported_once(tmp_path):
    stopped = study("flips", agent="random", p=[0], until="±45", most=300)
    trials = run_study(stopped, tmp_path)
    assert owed_trials(tmp_path) == 0
    assert len(trials) < 300
    sql(tmp_path, "delete from trial where id = (select max(id) from trial)")
    assert owed_trials(tmp_path) == 1


def test_it_is_written_when_records_have_grown_and_ends_with_the_last_of_them(tmp_path):
    run = Run(write_study(tmp_path / "study", STUDY, TRIALS[:1]), TRIALS[1:2], (), (), TRIALS[2:])
    run.watch()
    assert [trials for _, trials in run.reports] == [1, 2, 4]  # nothing grew in two of the waits
    assert run.reports[1][0] == PAUSE


def test_trials_that_end_while_a_report_is_written_are_in_the_next(tmp_path):
    run = Run(write_study(tmp_path / "study", STUDY, TRIALS[:1]), (), ())
    run.during[1] = TRIALS[1:]
    run.watch()
    assert [trials for _, trials in run.reports] == [1, 4]


def test_without_new_records_it_waits_until_it_is_stopped(tmp_path):
    run = Run(write_study(tmp_path / "study", STUDY, TRIALS[:2]), *[()] * 20)
    with pytest.raises(KeyboardInterrupt):
        run.watch()
    assert len(run.reports) == 1
    assert owed_trials(run.directory) == 2


def test_the_command_says_each_report_in_a_line_and_ctrl_c_is_no_failure(lockprobe, tmp_path, monkeypatch):
    monkeypatch.setattr(command, "write_report", lambda directory, **_: directory / "report.html")
    done = write_study(tmp_path / "done", STUDY, TRIALS)
    status, said, _ = lockprobe("report", done, "--watch", "--json")
    assert (status, [json.loads(line) for line in said.splitlines()]) == (0, [{"report": str(done / "report.html")}])

    def stop(seconds):
        raise KeyboardInterrupt

    monkeypatch.setattr(watch_report, "__kwdefaults__", {**watch_report.__kwdefaults__, "sleep": stop})
    half = write_study(tmp_path / "half", STUDY, TRIALS[:3])
    status, said, why = lockprobe("report", half, "--watch")
    assert (status, said) == (0, f"Report: {half / 'report.html'}\n")
    assert why == "Report: stopped by Ctrl-C; trials still owed: 1\n"
    assert lockprobe("report", tmp_path, "--watch")[0] == 2
