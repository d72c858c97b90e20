"""The report of a study that is being played: when it is written again, and when that ends."""

import json

import pytest
from builders import play_study, small_study, write_study
from stored import sql

from lockprobe.cli import report as command
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load
from lockprobe.studies.records.trial_rows import Timing
from lockprobe.studies.running.runner import run_study

STUDY = small_study(agents=("random",), p=(0.0,), repetitions=1, trials=4)
TRIALS = play_study(STUDY)


class Run:
    """A study that is played during reports and in the waits after them, by a clock that only this moves."""

    def __init__(self, directory, monkeypatch):
        self.directory = directory
        self.now, self.takes, self.reports, self.during, self.waits = 0.0, 0.0, [], {}, []
        monkeypatch.setattr(command, "write_report", self.report)
        monkeypatch.setattr(command, "time", self)

    def report(self, directory, **_):
        self.reports.append((self.now, len(load(directory))))
        self.play(self.during.pop(len(self.reports), ()))
        self.now += self.takes
        return directory / "report.html"

    def monotonic(self):
        return self.now

    def sleep(self, seconds):
        self.now += seconds
        if not self.waits:
            raise KeyboardInterrupt
        self.play(self.waits.pop(0))

    def play(self, trials):
        if not trials:
            return
        with Journal.open(self.directory, STUDY) as journal:
            for trial in trials:
                journal.append(trial, Timing(key=trial.key, seconds=1.0, steps=len(trial.steps)))


@pytest.fixture
def watched(tmp_path, monkeypatch, lockprobe):
    """From the trials at first, during the first report and in waits to what is printed, and the reports."""

    def watch(first, *waits, during=(), takes=0.0, more=()):
        run = Run(write_study(tmp_path / "study", STUDY, first), monkeypatch)
        run.waits, run.during, run.takes = list(waits), {1: during}, takes
        return *lockprobe("report", run.directory, "--watch", *more), run.reports

    return watch


def test_a_finished_study_is_reported_once(watched, tmp_path):
    status, said, _, reports = watched(TRIALS, more=["--json"])
    assert (status, json.loads(said)) == (0, {"report": str(tmp_path / "study" / "report.html")})
    assert reports == [(0.0, 4)]


@pytest.mark.parametrize("again", [False, True])
def test_a_study_that_stops_when_it_is_decided_is_over_then(tmp_path, lockprobe, monkeypatch, again):
    trials = run_study(study("flips", agent="random", p=[0], until="±45", most=300), tmp_path)
    assert len(trials) < 300
    run = Run(tmp_path, monkeypatch)
    if again:
        sql(tmp_path, "delete from trial where id = (select max(id) from trial)")
    assert lockprobe("report", tmp_path, "--watch")[2] == "Report: stopped by Ctrl-C; trials still owed: 1\n" * again
    assert len(run.reports) == 1


@pytest.mark.parametrize(("takes", "second"), [(1.0, 1.0 + command.PAUSE), (30.0, 60.0)])
def test_it_is_written_when_records_have_grown_in_half_of_the_time_and_ends_with_the_last(watched, takes, second):
    reports = watched(TRIALS[:1], TRIALS[1:2], (), (), TRIALS[2:], takes=takes)[-1]
    assert [trials for _, trials in reports] == [1, 2, 4]  # nothing grew in two of the waits
    assert reports[1][0] == second


def test_trials_that_end_while_a_report_is_written_are_in_the_next(watched):
    assert [trials for _, trials in watched(TRIALS[:1], (), (), during=TRIALS[1:])[-1]] == [1, 4]


def test_without_new_records_it_waits_until_ctrl_c_which_is_no_failure(watched, tmp_path, lockprobe):
    status, said, why, reports = watched(TRIALS[:2], *[()] * 20)
    assert (status, said, len(reports)) == (0, f"Report: {tmp_path / 'study' / 'report.html'}\n", 1)
    assert why == "Report: stopped by Ctrl-C; trials still owed: 2\n"
    assert lockprobe("report", tmp_path / "nowhere", "--watch")[0] == 2
