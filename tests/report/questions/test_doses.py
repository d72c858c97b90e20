"""Other doses than flip rates: the same numbers and figures over each, called by the name of the dose."""

from html import unescape

import pytest
from builders import write_study
from captions import too_long
from page_parts import part

from lockprobe.report.figures.palette import Style, colours, of_agent
from lockprobe.report.figures.success_by_flip_rate import success_by_dose
from lockprobe.report.page import page_of
from lockprobe.report.results import results
from lockprobe.report.svg import image
from lockprobe.studies.options.studyfile import study

READER = "cognitive:perseverant"
LAB = {"agent": [READER, "random"], "p": [0, 0.3, 0.6], "sweep": "tremble?p=0.1,0.2,0.4", "trials": 8, "repetitions": 2}
SMALL = {"trials": 6, "repetitions": 1}


def found_in(directory, **asked):
    return results(write_study(directory / "study", study("flips", **asked)))


def section(found):
    drawn = {"series-1-success": image(b"<svg />")}
    return unescape(part(page_of(found, drawn), "doses"))


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    """A study of flip rates and of one other dose."""
    return found_in(tmp_path_factory.mktemp("doses"), **LAB)


def test_a_dose_is_called_by_its_name(lab):
    (axis,) = [axis for axis in lab.design.axes if axis.key != "flip rate"]
    assert axis.key == "tremble p"
    assert axis.doses == {"truth": 0, "tremble?p=0.1": 0.1, "tremble?p=0.2": 0.2, "tremble?p=0.4": 0.4}
    findings = [one for one in lab.findings if one.section == "doses"]
    assert {one.kind for one in findings} == {"finding"}
    assert "Tremble p</h3>" in section(lab)
    said = [one.text for one in findings] + [row.note for row in lab.where("test", axis=axis.key)]
    assert any("tremble" in one for one in said)
    assert not [one for one in said if "flip" in one or "alse report" in one]


def test_numbers_are_of_the_trials_of_each_dose(lab):
    (axis,) = [axis for axis in lab.design.axes if axis.key != "flip rate"]
    for course in lab.courses(axis):
        assert [cell.dose for cell in course.cells] == [0, 0.1, 0.2, 0.4]
        assert (
            [row.value for row in course.where("trials_at_dose")] == [cell.trials for cell in course.cells] == [16] * 4
        )
        lowest, *others = [cell.value("success") for cell in course.cells]
        rows = course.against_lowest("success_difference")
        assert [row.value for row in rows] == pytest.approx([share - lowest for share in others])
        assert course.value("success_chance", "uniform") == lab.curve("success_by_step", of="uniform").value[-1]


def test_two_kinds_of_flips_are_told_apart(tmp_path):
    sticky = [f"flip?p={p}&others=kept" for p in (0.2, 0.4, 0.6)]
    found = found_in(tmp_path, agent=[READER], p=[0, 0.2, 0.4], condition=sticky, **SMALL)
    assert [axis.key for axis in found.design.axes] == ["flip rate", "flip rate (others=kept)"]
    first, second = found.courses()[0], found.courses(found.design.axes[1])[0]
    assert [cell.dose for cell in first.cells] == [0, 0.2, 0.4]
    assert [cell.condition for cell in second.cells] == ["truth", *sticky]
    for course in (first, second):
        assert [float(row.of) for row in course.where("trials_at_dose")] == [cell.dose for cell in course.cells]
    contrasts = [row.condition for row in found.against_control()]
    assert contrasts == ["flip?p=0.2", "flip?p=0.4", *sticky]
    assert not found.sections_left_out
    assert "false reports that stay" in " ".join(found.said("overview", "answer"))


@pytest.mark.parametrize("p", [[0], [0, 0.4]])
def test_options_of_an_agent_are_a_dose_without_another_condition(tmp_path, p):
    agents = [f"human-inspired?lapse={lapse}" for lapse in (0, 0.1, 0.3)]
    found = found_in(tmp_path, agent=agents, p=p, **SMALL)
    assert found.design.axes[-1].name == "lapse"
    assert "higher values of lapse" in found.said("doses", "finding")[0]
    assert not found.beside_flips


def test_doses_that_changed_nothing_are_in_no_number_and_no_figure(tmp_path):
    acts = ["history?last=50", *[f"history?last=50 + tremble?p={p}" for p in (0.1, 0.3, 0.5)]]
    found = found_in(tmp_path, agent=["human-inspired", "cognitive:careful"], p=[0], condition=acts, **SMALL)
    (axis,) = found.design.axes
    assert axis.key == "tremble p, with history?last=50"
    assert [[cell.dose for cell in course.cells] for course in found.courses(axis)] == [[0], [0]]
    assert "No test" in section(found)


def test_an_option_of_agents_is_a_dose(tmp_path):
    agents = [f"{READER}?stay={stay}" for stay in (1, 2, 3)]
    found = found_in(tmp_path, agent=agents, p=[0], condition=["nudge"], **SMALL)
    (axis,) = found.design.axes
    assert (axis.key, axis.condition, axis.intervention) == ("stay", "truth", "agent")
    (course,) = found.courses(axis)
    assert [(cell.agent, cell.dose) for cell in course.cells] == list(zip(agents, [1, 2, 3], strict=True))
    assert course.agent == READER
    assert course.get("test", "success") is not None
    assert "Stay</h3>" in section(found)


def test_captions_are_short(lab):
    assert too_long(page_of(lab), lab.plain()) == []


def test_an_option_of_an_agent_is_drawn_as_an_axis_in_the_colour_of_the_agent(tmp_path):
    found = found_in(tmp_path, agent="human-inspired", sweep="agent.lapse=0,0.1,0.3", p=[0], **SMALL)
    (axis,) = found.design.axes
    assert axis.name == "lapse"
    (course,) = found.courses(axis)
    assert of_agent(course, Style(colour="black")).colour == colours([course])["human-inspired", course.modality]
    assert success_by_dose(found, 0).axes
