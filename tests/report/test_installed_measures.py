"""Measures of installed packages: in results.json, in a table and on the page; none where no package adds one."""

import strangers
from builders import play_study, small_study, write_study

from lockprobe.foundation.formatting import NONE
from lockprobe.report.installed_measures import measure_rows
from lockprobe.report.opened import open_study
from lockprobe.report.pages import tables_of
from lockprobe.report.results import results
from lockprobe.report.study_numbers import study_numbers
from lockprobe.report.verify.verification import verify
from lockprobe.report.write import write_report
from lockprobe.statistics.measures import measured

STUDY = small_study(["random"], p=[0.0, 0.6], repetitions=1)
POINTS = {"measures": {"untold": "untold", "hasty": "hasty", "breaks": "breaks"}}


def test_every_condition_has_the_mean_of_each_and_of_one_that_breaks_the_reason(tmp_path, monkeypatch):
    strangers.install(tmp_path, monkeypatch, points=POINTS)
    trials = play_study(STUDY)
    *rows, first, second = measure_rows(study_numbers(open_study(write_study(tmp_path / "study", STUDY, trials))))
    assert [(row.agent, row.condition, row.quantity) for row in rows] == [
        ("random", condition, f"measures.{name}")
        for condition in ("truth", "flip?p=0.6")
        for name in ("breaks", "hasty", "untold")
    ]
    assert (first.name, second.name) == ("hasty", "untold")
    assert {row.source for row in rows} == {"strange-things 0.3"}
    for row in rows:
        if row.quantity == "measures.breaks":
            assert (row.unit, row.n, row.value, row.low, row.high) == ("", 0, None, None, None)
            assert "does not work (ZeroDivisionError: by nothing)" in row.note
            continue
        (found,) = measured(
            [trial for trial in trials if trial.condition == row.condition], [row.quantity.removeprefix("measures.")]
        )
        assert (row.value, row.low, row.high, row.n) == (found.value, found.low, found.high, 4)


def test_the_table_writes_a_mean_with_its_interval_and_a_dash_without_one(tmp_path, monkeypatch):
    strangers.install(tmp_path, monkeypatch, points=POINTS)
    found = results(write_study(tmp_path / "study", STUDY))
    head, *lines = tables_of(found)["measures"]
    assert head[-1] == "mean [95 % interval]"
    said = {(line[1], line[2]): line[-1] for line in lines}
    assert {said["truth", "breaks"], said["flip?p=0.6", "breaks"]} == {NONE}
    assert {said["truth", "untold"], said["flip?p=0.6", "untold"]} == {"0"}  # the same in every trial: no interval
    hasty = found.one("measures.hasty", condition="truth")
    assert said["truth", "hasty"] == f"{hasty.value:.3g} [{hasty.low:.3g}, {hasty.high:.3g}]"


def test_a_report_shows_them(tmp_path, monkeypatch):
    path = write_study(tmp_path / "study", STUDY)
    write_report(path)
    assert results(path).measures == []
    without = (path / "details.html").read_text("utf-8")
    assert not (path / "tables" / "measures.csv").exists()
    strangers.install(tmp_path, monkeypatch, points=POINTS)
    write_report(path)
    assert len(results(path).measures) == 6
    page = (path / "details.html").read_text("utf-8")
    assert "Whether it was solved in five steps" in page
    assert "Whether it was solved in five steps" not in without


def test_verification_takes_them_from_the_results_and_runs_no_package(tmp_path, monkeypatch):
    with monkeypatch.context() as installed:
        strangers.install(tmp_path, installed, points=POINTS)
        directory = write_study(tmp_path / "study", STUDY)
        write_report(directory)
    checks = {check.name: check for check in verify(directory)}
    assert all(check.holds for check in checks.values())
    assert checks["results"].said.endswith("; 8 of its rows are not checked: they come from strange-things 0.3")
