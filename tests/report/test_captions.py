"""Captions name lines, marks and stars only where they are drawn, and say how intervals of people are clustered."""

import pytest
from builders import played_by_people, small_study, write_study

from lockprobe.report.captions import paper_rates, share_intervals_said
from lockprobe.report.opened import open_study
from lockprobe.report.pages import page_of
from lockprobe.report.results import results_of
from lockprobe.report.sections import effects, success
from lockprobe.report.study_numbers import study_numbers
from lockprobe.studies.options.studyfile import study

AGENTS = ("cognitive:perseverant", "random")
SMALL = {"agent": list(AGENTS), "trials": 8, "repetitions": 2}


def found_in(directory, planned, trials=None):
    return results_of(study_numbers(open_study(write_study(directory / "study", planned, trials))))


@pytest.fixture(scope="module")
def over(tmp_path_factory):
    """Results over flip rates."""
    return lambda *rates: found_in(tmp_path_factory.mktemp("captions"), small_study(AGENTS, rates, 2, 8))


def caption(section, name, found):
    (figure,) = (one for one in section.SECTIONS[0].figures if one.name == name)
    said = figure.caption(found)
    return f"{said.shown} {said.computed}"


def test_a_line_and_its_band_are_named_exactly_where_a_curve_is_drawn(over):
    seen = set()
    for found in (over(0.0, 0.4), over(0.0, 0.2, 0.4, 0.6)):
        (course,) = (one for one in found.courses() if one.subject)
        for name, curve in (("fig4", "success_fit"), ("fig4-corrected", "success_model")):
            drawn = course.curve(curve) is not None
            assert ("The line is" in caption(success, name, found)) == drawn
            seen.add(drawn)
    assert seen == {True, False}


def test_only_the_stars_within_the_axis_are_named(over):
    narrow, wide, none = over(0.0, 0.3), over(0.0, 0.4), over(0.1, 0.3)
    assert [paper_rates(one.courses()) for one in (narrow, wide, none)] == [[0.0], [0.0, 0.4], []]
    said = [caption(success, "fig4", one) for one in (narrow, wide, none)]
    assert ["at a flip rate of 0" in one for one in said] == [True, True, False]
    assert ["at 0.4" in one for one in said] == [False, True, False]
    assert ["Hollow stars" in one for one in said] == [True, True, False]


def test_squares_are_named_only_with_interactions(tmp_path):
    alone = found_in(tmp_path / "a", study("flips", **SMALL, p=[0], condition=["drop?p=0.3", "tremble?p=0.3"]))
    crossed = ["nudge", "nudge + flip?p=0.6"]
    both = found_in(tmp_path / "b", study("flips", **SMALL, p=[0, 0.6], condition=crossed))
    assert both.where("success_interaction", axis="")
    assert ["quares" in caption(effects, "effects", one) for one in (alone, both)] == [False, True]


def test_no_interval_of_people_is_called_a_plain_wilson_interval(tmp_path):
    planned = study("flips", agent=["participant"], p=[0, 0.3], trials=6, repetitions=2)
    found = found_in(tmp_path, planned, played_by_people(planned, 2))
    page = page_of("report", found) + page_of("details", found)
    said = {one.partition(".")[0] for one in page.split("Intervals are ")[1:]}
    assert said
    assert not any("Wilson" in one for one in said if "each person has one box" not in one)
    assert "Intervals of success and loop rate are 95 % intervals clustered by person." in page
    assert share_intervals_said(["participant", "random"]) == (
        "Intervals are 95 % Wilson intervals, clustered by person for people."
    )
