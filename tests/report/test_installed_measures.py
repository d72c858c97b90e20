"""Measures of installed packages: in results.json, in a table and on the page; none where no package adds one."""

import json

import strangers
from builders import play_study, small_study, write_study

from lockprobe.analysis.measures import measured
from lockprobe.formatting import NONE
from lockprobe.report import write_report
from lockprobe.report.installed_measures import measure_rows, measure_table
from lockprobe.report.opened import open_study
from lockprobe.report.verification import verify

STUDY = small_study(["random"], p=[0.0, 0.6], repetitions=1)
MEASURES = {"measures": {"untold": "untold", "hasty": "hasty", "breaks": "breaks"}}


def test_every_condition_has_the_mean_of_each_and_of_one_that_breaks_the_reason(tmp_path, monkeypatch):
    strangers.install(tmp_path, monkeypatch, points=MEASURES)
    trials = play_study(STUDY)
    rows = measure_rows(open_study(write_study(tmp_path / "study", STUDY, trials)))
    assert [(row.agent, row.condition, row.measure) for row in rows] == [
        ("random", condition, name) for condition in ("truth", "flip?p=0.6") for name in ("breaks", "hasty", "untold")
    ]
    for row in rows:
        if row.measure == "breaks":
            assert (row.kind, row.trials, row.value, row.low, row.high) == ("broken", 0, None, None, None)
            assert "does not work (ZeroDivisionError: by nothing)" in row.what
            continue
        (found,) = measured([trial for trial in trials if trial.condition == row.condition], [row.measure])
        assert (row.value, row.low, row.high, row.trials) == (found.value, found.low, found.high, 4)


def test_the_table_writes_a_mean_with_its_interval_and_a_dash_without_one(tmp_path, monkeypatch):
    strangers.install(tmp_path, monkeypatch, points=MEASURES)
    rows = measure_rows(open_study(write_study(tmp_path / "study", STUDY)))
    head, *lines = measure_table(rows)
    assert head[-1] == "mean [95 % interval]"
    said = {(line[1], line[2]): line[-1] for line in lines}
    assert {said["truth", "breaks"], said["flip?p=0.6", "breaks"]} == {NONE}
    assert {said["truth", "untold"], said["flip?p=0.6", "untold"]} == {"0"}  # the same in every trial: no interval
    hasty = next(row for row in rows if row.measure == "hasty")
    assert said["truth", "hasty"] == f"{hasty.value:.3g} [{hasty.low:.3g}, {hasty.high:.3g}]"


def test_a_report_shows_them(tmp_path, monkeypatch):
    path = write_study(tmp_path / "study", STUDY)
    write_report(path)
    assert json.loads((path / "results.json").read_text("utf-8"))["measures"] == []
    without = (path / "report.html").read_text("utf-8")
    strangers.install(tmp_path, monkeypatch, points=MEASURES)
    write_report(path)
    found = json.loads((path / "results.json").read_text("utf-8"))["measures"]
    assert len(found) == 6
    page = (path / "report.html").read_text("utf-8")
    assert "Whether it was solved in five steps" in page
    assert "Whether it was solved in five steps" not in without


def test_verification_takes_them_from_the_results_and_runs_no_package(tmp_path, monkeypatch):
    with monkeypatch.context() as installed:
        strangers.install(tmp_path, installed, points=MEASURES)
        directory = write_study(tmp_path / "study", STUDY)
        write_report(directory)
    checks = {check.name: check for check in verify(directory)}
    assert all(check.holds for check in checks.values())
    assert checks["results"].said.endswith("; 6 values by measures of packages are taken from it")
