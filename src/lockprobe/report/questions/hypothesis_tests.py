"""Hypothesis tests: every question of an agent, with the test that conclusions rest on."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import cast

from lockprobe.foundation.formatting import NONE, p_cell
from lockprobe.report.format import TextTable
from lockprobe.report.prose.hypothesis_tests import asked, effect_said, note_said
from lockprobe.report.prose.section_answers import NO_NUMBERS
from lockprobe.report.prose.subject import Subject
from lockprobe.report.rows import Course, Estimate, Results, Row
from lockprobe.report.section import Block, Cells, Detail, Heading, Note, Part, Section, Template, Text
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.report.table_rows import value_cell
from lockprobe.statistics.conditions.axis import FLIPS, Axis
from lockprobe.statistics.inference.verdict import Question
from lockprobe.statistics.proportions import ALPHA


@dataclass(frozen=True, slots=True)
class _Line:
    """A line of the table of tests."""

    asks: str
    test: str
    p_value: str
    estimate: str
    conclusion: str
    note: str


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    yield from numbers.answer("hypothesis_tests", "test")  # the tests are among the rows of each course


def tables_of_tests(courses: Iterable[Course], axis: Axis) -> list[Block]:
    """A table of tests over this axis for each agent that has some, by name."""
    blocks: list[Block] = []
    for course in sorted(courses, key=lambda course: course.label.lower()):
        if lines := [_line(course, test, axis) for test in course.where("test")]:
            name = Subject.of(course.agent, course.shown).name
            blocks += [Heading(name, code=True), Template("tests", {"lines": lines})]
    return blocks


def _line(course: Course, test: Estimate, axis: Axis) -> _Line:
    return _Line(
        asks=asked(cast("Question", test.of), axis),
        test=test.test,
        p_value=p_cell(test.p_value),
        estimate=_estimate(course, test, axis),
        conclusion=_conclusion(test, "yes"),
        note=_note(course, test, axis),
    )


def _note(course: Course, test: Estimate, axis: Axis) -> str:
    """Why the test is missing; else how to interpret it, and what limits it."""
    if test.note and test.p_value is None:
        return test.note
    return f"{note_said(test.test, axis)} {test.note}".strip()


def _estimate(course: Course, test: Estimate, axis: Axis) -> str:
    """The effect with its interval, and what it is."""
    if test.value is None:
        return ""
    said = effect_said(test.test, axis)
    return f"{value_cell(test)}{f' ({said})' * bool(said)}"


def _conclusion(test: Estimate, rejected: str) -> str:
    if test.p_value is None:
        return NONE
    return rejected if test.p_value < ALPHA else "not detected"


_SHORT: Mapping[Question, str] = {
    "success": "success differs",
    "speed": "steps differ",
    "shape": "rise and fall",
    "looping": "first loop differs",
    "looping again": "loops later, then sooner",
}
"""Question -> the head of its column."""


def _overview(courses: Iterable[Course]) -> TextTable:
    """What the tests say of each agent: a column for each question."""
    rows = []
    for course in sorted(courses, key=lambda course: course.label.lower()):
        tests = {test.of: test for test in course.where("test")}
        if tests:
            name = Subject.of(course.agent, course.shown).name
            rows.append([name, *(_verdict(tests.get(question)) for question in _SHORT)])
    return [["agent", *_SHORT.values()], *rows] if rows else []


def _verdict(test: Estimate | None) -> str:
    """What a test concludes, with its P value."""
    if test is None or test.p_value is None:
        return NONE
    return f"{_conclusion(test, 'detected')} ({p_cell(test.p_value)})"


def _show(found: Results) -> Iterator[Part]:
    yield Part("Hypothesis tests", found.answer_of("hypothesis_tests") or NO_NUMBERS, list(_blocks(found)))


def _blocks(found: Results) -> Iterator[Block]:
    if not found.several_p:
        above = "conditions" if found.beside_flips else "modalities" if found.where("modality_effect") else ""
        said = f"; tests of {'other ' * (above == 'conditions')}{above} are above" if above else ""
        yield Text(f"With one flip rate, effects of false reports cannot be tested{said}.")
        return
    courses = [course for course in found.courses() if course.subject]
    if overview := _overview(courses):
        yield Cells(overview, 1)
        yield Note("One test for each question, with its P value, which is not corrected for the number of questions.")
    if tables := tables_of_tests(courses, FLIPS):
        yield Detail("Every test, with its estimate", tables)
    else:
        yield Text("No agent has trials that differ between flip rates.")


SECTIONS = (Section(name="hypothesis_tests", title="Hypothesis tests", rows=_rows, show=_show),)
