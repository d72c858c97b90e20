"""Options that are no numbers: conditions that differ in one alone stand in rows, a table and a part of the page."""

import pytest
from builders import write_study

from lockprobe.report.opened import open_study
from lockprobe.report.pages import page_of, tables_of
from lockprobe.report.results import results_of
from lockprobe.report.study_numbers import study_numbers
from lockprobe.studies.options.studyfile import study

STICKY = "flip?p=0.6&others=kept"


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    asked = study(
        "flips", agent=["cognitive:perseverant"], p=[0, 0.6], condition=[STICKY, "nudge"], trials=8, repetitions=2
    )
    return results_of(study_numbers(open_study(write_study(tmp_path_factory.mktemp("lab") / "study", asked))))


def test_a_level_is_compared_with_the_first_one_beside_the_control(found):
    (row,) = found.where("success_difference", axis="flip others")
    assert (row.condition, row.control, row.family, row.corrected_for) == (
        STICKY, "flip?p=0.6", "levels of flip others", 1,
    )  # fmt: skip
    pair = {"agent": row.agent, "condition": STICKY, "control": "flip?p=0.6"}
    second, first = (found.one("success_in_pairs", **pair, of=of).value for of in ("", "the control"))
    assert row.value == pytest.approx(second - first)
    assert row not in found.against_control()
    assert STICKY in {one.condition for one in found.against_control()}


def test_the_table_and_the_page_show_it(found):
    assert [line[:3] for line in tables_of(found)["readings-compared"]] == [
        ["agent", "condition", "control"],
        ["cognitive:perseverant", STICKY, "flip?p=0.6"],
    ]
    assert not tables_of(found).get("factors")  # readings have a section of their own
    assert "Options compared" not in page_of("report", found)
