"""Measures of installed packages: in results.json, in a table and on the page, and what verification says of them."""

import pytest
import strangers
from builders import play_study, small_study, write_study

from lockprobe.foundation.formatting import NONE
from lockprobe.report.opened import open_study
from lockprobe.report.page import tables_of
from lockprobe.report.questions.conditions import measure_rows
from lockprobe.report.results import results
from lockprobe.report.rows import Results
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.report.verify.verification import verify
from lockprobe.report.write import write_report
from lockprobe.statistics.measures import measured

STUDY = small_study(["random"], p=[0.0, 0.6], repetitions=1)
POINTS = {"measures": {"untold": "untold", "hasty": "hasty", "breaks": "breaks"}}


def test_every_condition_has_the_mean_of_each_and_of_one_that_breaks_the_reason(tmp_path, monkeypatch):
    strangers.install(tmp_path, monkeypatch, points=POINTS)
    trials = play_study(STUDY)
    *rows, first, second = measure_rows(StudyNumbers(opened=open_study(write_study(tmp_path / "study", STUDY, trials))))
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
    without = (path / "report.html").read_text("utf-8")
    assert not (path / "tables" / "measures.csv").exists()
    strangers.install(tmp_path, monkeypatch, points=POINTS)
    write_report(path)
    assert len(results(path).measures) == 6
    page = (path / "report.html").read_text("utf-8")
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


@pytest.fixture(scope="module")
def reported(tmp_path_factory):
    """A study with a report without packages."""
    directory = write_study(tmp_path_factory.mktemp("strange") / "study", small_study(["random"], (0.0, 0.3), 1, 3))
    write_report(directory)
    return directory


def _added(reported, row):
    write_report(reported)
    path = reported / "results.json"
    path.write_text(path.read_text("utf-8").replace(' "rows": [\n', f' "rows": [\n  {row},\n'), "utf-8")
    (failed,) = [check for check in verify(reported) if not check.holds]
    return failed


def test_what_has_a_name_of_ours_is_checked_whoever_is_said_to_have_made_it(reported):
    made_up = '{"quantity": "success", "agent": "random", "condition": "truth", "value": 0.99, "source": "some 1.0"}'
    assert _added(reported, made_up).failed == (f"written: {made_up}",)


def test_a_column_without_a_value_and_two_values_of_a_name_are_named(reported):
    write_report(reported)
    path = reported / "results.json"
    text = path.read_text("utf-8")
    for edit in ('"family": null', '"value": 0.99'):
        path.write_text(text.replace('"quantity": "success",', f'"quantity": "success", {edit},', 1), "utf-8")
        (failed,) = [check for check in verify(reported) if not check.holds]
        assert failed.name == "results"
        assert failed.failed[0].startswith(f'written: {{"quantity": "success", {edit}')


def test_a_row_that_names_no_package_is_checked(reported):
    """Who makes numbers up may call them those of a measure, but not of Lockprobe."""
    made_up = '{"quantity": "measures.made_up", "value": 1}'
    assert _added(reported, made_up).failed == (f"written: {made_up}",)


def test_a_measure_with_the_name_of_a_number_of_lockprobe_is_told_apart(tmp_path, monkeypatch, reported):
    alone = results(reported)
    strangers.install(tmp_path, monkeypatch, points={"measures": {"steps": "untold"}})
    write_report(reported)
    found = Results.model_validate_json((reported / "results.json").read_bytes())
    assert found.sections_left_out == ()
    assert [row.quantity for row in found.measures] == ["measures.steps"] * 2
    assert [row for row in found.rows if not row.source] == [*alone.rows]
    assert all(check.holds for check in verify(reported))
