"""Hypothesis tests: every question of an agent, with the test to conclude from and those that others use."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import cast

from markupsafe import Markup

from lockprobe.foundation.formatting import NONE, p_cell, range_of
from lockprobe.report.format import TextTable
from lockprobe.report.prose.hypothesis_tests import asked, effect_said, note_said
from lockprobe.report.prose.section_answers import NO_NUMBERS
from lockprobe.report.prose.subject import Subject
from lockprobe.report.rows import Course, Estimate, Results, Row
from lockprobe.report.section import Block, Cells, Detail, Heading, Note, Part, Section, Template, Text
from lockprobe.report.sections.course_rows import RULE
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.report.table_rows import value_cell
from lockprobe.simulation.audit.rates import false_positives, measured
from lockprobe.statistics.conditions.axis import FLIPS, Axis
from lockprobe.statistics.inference.verdict import Question
from lockprobe.statistics.proportions import ALPHA

__all__ = ["SECTIONS", "tables_of_tests"]


@dataclass(frozen=True, slots=True)
class _Line:
    """A line of the table of tests; ``asks`` is empty unless conclusions rest on the test."""

    asks: str
    test: str
    p_value: str
    estimate: str
    false_positives: str
    conclusion: str
    note: str


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    yield from numbers.answer("hypothesis_tests", "test")  # the tests are among the rows of each course


def tables_of_tests(courses: Iterable[Course], axis: Axis, *, testable: bool = True) -> list[Block]:
    """A table of tests for each agent that has some, by name.

    Args:
        courses: The agents.
        axis: The axis that their tests are over.
        testable: Whether there are several doses; if not, only questions that need none are shown.
    """
    blocks: list[Block] = []
    for course in sorted(courses, key=lambda course: course.label.lower()):
        valid = [test for test in course.where("test") if testable or test.p_value is not None]
        lines = [line for test in valid for line in _lines(course, test, axis)]
        if lines:
            name = Subject.of(course.agent, course.shown).name
            blocks += [Heading(name, code=True), Template("tests", {"lines": lines})]
    return blocks


@cache
def _excessive() -> frozenset[str]:
    """The tests that reject too often in a simulated world of the audit."""
    return frozenset(rate.test for rate in measured() if rate.valid is False and not rate.recommended)


def _lines(course: Course, valid: Estimate, axis: Axis) -> Iterator[_Line]:
    """The test of a question that conclusions rest on, and the others."""
    others = [test for test in course.where("naive_test") if test.of.startswith(f"{valid.of}: ")]
    for test in (valid, *others):
        rates = false_positives(test.test)
        conclusion = _conclusion(test, valid=test.test not in _excessive())
        yield _Line(
            asks=asked(cast("Question", valid.of), axis) if test is valid else "",
            test=test.test,
            p_value=p_cell(test.p_value),
            estimate=_estimate(course, test, axis),
            false_positives=range_of(rates[0].rate, rates[1].rate, 1) if rates else "",
            conclusion=conclusion,
            note=_note(course, test, axis),
        )


def _note(course: Course, test: Estimate, axis: Axis) -> str:
    """Why the test is missing; else how to interpret it, and what limits it."""
    if test.note and test.p_value is None:
        return test.note
    return f"{note_said(test.test, axis, course.value('test_null', test.of))} {test.note}".strip()


def _estimate(course: Course, test: Estimate, axis: Axis) -> str:
    """The effect with its interval, what it is, and what it is for a blind agent, where that is the null hypothesis."""
    if test.value is None or test.unit == RULE:
        return ""
    said, null = effect_said(test.test, axis), course.value("test_null", test.of)
    blind = "" if null is None else f"; a blind agent with the same action habits: {null:.2f}"
    return f"{value_cell(test)}{f' ({said})' * bool(said)}{blind}"


def _conclusion(test: Estimate, *, valid: bool) -> str:
    if test.unit == RULE:
        rejects = bool(test.value)
    elif test.p_value is None:
        return NONE
    else:
        rejects = test.p_value < ALPHA
    return "not detected" if not rejects else "yes" if valid else "not valid (rejects)"


_SHORT: Mapping[Question, str] = {
    "success": "success differs",
    "speed": "steps differ",
    "shape": "rise and fall",
    "looping": "first loop differs",
    "looping again": "loops later, then sooner",
    "harm": "harm of loops",
}
"""Question -> the head of its column."""


def _overview(courses: Iterable[Course]) -> TextTable:
    """What the recommended tests say of each agent: a column for each question."""
    rows = []
    for course in sorted(courses, key=lambda course: course.label.lower()):
        tests = {test.of: test for test in course.where("test")}
        if tests:
            name = Subject.of(course.agent, course.shown).name
            rows.append([name, *(_verdict(tests.get(question)) for question in _SHORT)])
    return [["agent", *_SHORT.values()], *rows] if rows else []


def _verdict(test: Estimate | None) -> str:
    """What a test concludes, with its P value."""
    if test is None or (test.p_value is None and test.unit != RULE):
        return NONE
    said = _conclusion(test, valid=True).replace("yes", "detected")
    return said if test.p_value is None else f"{said} ({p_cell(test.p_value)})"


def _show(found: Results) -> Iterator[Part]:
    yield Part("Hypothesis tests", found.answer_of("hypothesis_tests") or NO_NUMBERS, list(_blocks(found)))


def _blocks(found: Results) -> Iterator[Block]:
    if not found.several_p:
        above = "conditions" if found.beside_flips else "modalities" if found.where("modality_effect") else ""
        said = f"; tests of {'other ' * (above == 'conditions')}{above} are above" if above else ""
        yield Text(f"With one flip rate, effects of false reports cannot be tested{said}.")
    courses = [course for course in found.courses() if course.subject]
    if overview := _overview(courses):
        yield Cells(overview, 1)
        yield Note(
            "One test for each question, with its P value. It keeps its error rate in the simulations of the audit.",
            "P values are not corrected for the number of questions.",
        )
    tables = tables_of_tests(courses, FLIPS, testable=found.several_p)
    if found.several_p and not tables:
        yield Text("No agent has trials that differ between flip rates.")
    if tables:
        yield Detail("Every test, with its estimate and the tests of the paper", [_NOTE, *tables])


_NOTE = Note(
    "Each question has one test that keeps its error rate in the simulations of the audit (bold). The other tests "
    "(grey) are the paper's or common choices.",
    Markup(
        "False positives: how often a test rejects a true null hypothesis in simulated studies of the paper's size "
        '(<a href="audit.html">full audit</a>), from the best to the worst simulated world. Rates of valid tests '
        "are compatible with 5 %, up to about 7 % in 1000 simulated studies; <i>P</i> values are not corrected for "
        "the number of questions."
    ),
    lead=True,
)

SECTIONS = (Section(name="hypothesis_tests", title="Hypothesis tests", rows=_rows, show=_show),)
