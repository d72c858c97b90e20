"""Every column says what stands in it, and what is measured has a unit and a clock."""

from pathlib import Path

from lockprobe.interfaces.export import COLUMNS, TRIAL_COLUMNS
from lockprobe.interfaces.export.data_dictionary import COLUMN, PLATFORM, column


def test_what_is_measured_has_a_unit_and_a_clock():
    measured = {name: about for name, about in COLUMN.items() if name.endswith("_ms") or name == "at"}
    assert set(measured) == {"rt_ms", "claimed_rt_ms", "claim_rt_ms", "at"}
    assert {about.unit for about in measured.values()} == {"ms", "s"}
    assert all("clock" in about.meaning and about.least == 0 for about in measured.values())


def test_every_tidy_column_is_described():
    assert {*COLUMNS, *TRIAL_COLUMNS} <= set(COLUMN)
    assert all(about.meaning.strip().endswith(".") for about in COLUMN.values())


def test_a_column_of_the_platform_says_which_parameter_it_is():
    assert "STUDY_ID" in column(f"{PLATFORM}STUDY_ID").meaning


def test_the_docs_name_every_column():
    text = (Path(__file__).parents[3] / "docs" / "export.md").read_text("utf-8")
    names = {*COLUMNS, *TRIAL_COLUMNS, "condition", "chosen", "panel", "verdict"}
    assert {name for name in names if f"`{name}`" not in text} == set()
