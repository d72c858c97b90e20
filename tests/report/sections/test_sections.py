"""Rows of measures that packages add beside Lockprobe's own: whose they are, and what verification says of them."""

import pytest
import strangers
from builders import small_study, write_study

from lockprobe.report.results import results
from lockprobe.report.rows import Results
from lockprobe.report.verify.verification import verify
from lockprobe.report.write import write_report


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """A study with a report without packages."""
    directory = write_study(tmp_path_factory.mktemp("strange") / "study", small_study(["random"], (0.0, 0.3), 1, 3))
    write_report(directory)
    return directory


def _added(study, row):
    write_report(study)
    path = study / "results.json"
    path.write_text(path.read_text("utf-8").replace(' "rows": [\n', f' "rows": [\n  {row},\n'), "utf-8")
    (failed,) = [check for check in verify(study) if not check.holds]
    return failed


def test_what_has_a_name_of_ours_is_checked_whoever_is_said_to_have_made_it(study):
    made_up = '{"quantity": "success", "agent": "random", "condition": "truth", "value": 0.99, "source": "some 1.0"}'
    assert _added(study, made_up).failed == ("rows: success of some 1.0 has a name of Lockprobe's rows",)


def test_a_column_without_a_value_and_two_values_of_a_name_are_named(study):
    write_report(study)
    path = study / "results.json"
    text = path.read_text("utf-8")
    path.write_text(text.replace('"quantity": "success",', '"quantity": "success", "family": null,', 1), "utf-8")
    (failed,) = [check for check in verify(study) if not check.holds]
    assert "family None written, None computed" in failed.failed[0]
    path.write_text(text.replace('"quantity": "success",', '"quantity": "success", "value": 0.99,', 1), "utf-8")
    (failed,) = [check for check in verify(study) if not check.holds]
    assert failed.said == "results.json is damaged (two values of value)"


def test_a_row_that_names_no_package_is_checked(study):
    """Who makes numbers up may call them those of a measure, but not of Lockprobe."""
    made_up = '{"quantity": "measures.made_up", "value": 1}'
    assert _added(study, made_up).failed == ("rows: measures.made_up is no row of this report",)


def test_a_measure_with_the_name_of_a_number_of_lockprobe_is_told_apart(tmp_path, monkeypatch, study):
    alone = results(study)
    strangers.install(tmp_path, monkeypatch, points={"measures": {"steps": "untold"}})
    write_report(study)
    found = Results.model_validate_json((study / "results.json").read_bytes())
    assert found.sections_left_out == ()
    assert [row.quantity for row in found.measures] == ["measures.steps"] * 2
    assert [row for row in found.rows if not row.source] == [*alone.rows]
    assert all(check.holds for check in verify(study))
