"""Captions name lines, marks and stars only where they are drawn, and say how intervals of people are clustered."""

import pytest
from builders import played_by_people, small_study
from reported import found_in

from lockprobe.report.page import page_of
from lockprobe.report.prose import share_intervals_said
from lockprobe.studies.options.studyfile import study

AGENTS = ("cognitive:perseverant", "random")


@pytest.fixture(scope="module")
def over(tmp_path_factory):
    """Results over flip rates."""
    return lambda *rates: found_in(tmp_path_factory.mktemp("captions"), small_study(AGENTS, rates, 2, 8))


def test_no_interval_of_people_is_called_a_plain_wilson_interval(tmp_path):
    planned = study("flips", agent=["participant"], p=[0, 0.3], trials=6, repetitions=2)
    found = found_in(tmp_path, planned, played_by_people(planned, 2))
    page = page_of(found)
    said = {one.partition(".")[0] for one in page.split("Intervals are ")[1:]}
    assert said
    assert not any("Wilson" in one for one in said if "each person has one box" not in one)
    assert "Intervals of success and loop rate are 95 % intervals clustered by person." in page
    assert share_intervals_said(["participant", "random"]) == (
        "Intervals are 95 % Wilson intervals, clustered by person for people."
    )
