"""Other doses than flip rates: the same numbers, figures and tests over each of them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from lockprobe.foundation.formatting import capital, listed
from lockprobe.report.captions import model_said, share_intervals_said
from lockprobe.report.prose.readings import false_reports
from lockprobe.report.prose.success import finding
from lockprobe.report.questions.course_rows import AgentCourse, course_rows
from lockprobe.report.questions.hypothesis_tests import tables_of_tests
from lockprobe.report.questions.loops import loops_over_doses
from lockprobe.report.rows import DoseAxis, Finding, Results, Row
from lockprobe.report.section import Block, Caption, Detail, Figure, Part, Section, Text
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.statistics.conditions.axis import FLIPS, Axis, axis_key
from lockprobe.trial.record import PLAIN_WORDS


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    for i, (number, series, summary) in enumerate(numbers.series, 1):
        axis = axis_key(series.axis.name, series.axis.options, series.axis.rest, number)
        for agent in summary.agents:
            course = AgentCourse(agent, axis, numbers.conditions)
            yield from course_rows(course, summary.reference)
        for agent in summary.subjects:
            about: dict[str, Any] = {"section": _name(i), "agent": agent.agent, "modality": agent.modality}
            yield Finding(**about, kind="finding", text=finding(agent), rests_on=("clearest_success_difference",))
    for one in numbers.dose_courses:
        yield from loops_over_doses(one)


def _name(number: int) -> str:
    return "doses" if number == 1 else f"doses-{number}"


def _axes(found: Results) -> list[tuple[int, DoseAxis]]:
    """The axes that are not flip rates, each with its place among all axes."""
    return [(place, axis) for place, axis in enumerate(found.design.axes) if axis.key != FLIPS.name]


def _show(found: Results) -> Iterator[Part]:
    for i, (place, axis) in enumerate(_axes(found), 1):
        options = f" ({axis.options})" if axis.options else ""
        rest = f", with {axis.rest}" if axis.rest else ""
        shown = f", shown as {axis.modality}" if axis.modality not in PLAIN_WORDS else ""
        doses = listed([f"{dose:g}" for dose in sorted(set(axis.doses.values()))])
        answer = f"Shares of trials solved at {doses}."
        blocks = list(_blocks(found, axis, i, place))
        called = f"{axis.name.capitalize()}{options}{rest}"
        if axis.of_flips and axis.options:
            called = capital(false_reports(axis.options))
        yield Part(f"{called}{shown}", answer, blocks, _name(i))


def _blocks(found: Results, axis: DoseAxis, number: int, place: int) -> Iterator[Block]:
    yield from map(Text, found.said(_name(number), "finding"))
    yield _figure(found, axis, number, place)
    over = Axis(kind=axis.intervention, dose=axis.dose, options=axis.options, rest=axis.rest)
    untested = Text("No agent has trials that differ between doses.")
    tests = tables_of_tests(found.courses(axis), over) or [untested]
    yield Detail(f"All tests of {axis.name}", tests)


def _figure(found: Results, axis: DoseAxis, number: int, place: int) -> Figure:
    """Success over the axis."""
    shown = [course for course in found.courses(axis) if course.played]
    of_success = share_intervals_said([course.agent for course in shown], every_look=bool(found.progress.every_look))
    return Figure(
        f"series-{number}-success",
        f"Success by {axis.name}",
        Caption(
            f"Share of trials solved by {axis.name}, with the exact success of random agents.",
            f"{of_success} {model_said(shown)}".strip(),
        ),
        "lockprobe.report.figures.success_by_flip_rate:success_by_dose",
        arguments=(place,),
    )


SECTIONS = (Section(name="doses", title="Doses", rows=_rows, show=_show),)
