"""Factors: options that are no numbers, such as what becomes of a false report, each level against the first."""

from __future__ import annotations

from collections.abc import Iterator

from markupsafe import Markup

from lockprobe.report.format import TextTable
from lockprobe.report.questions.effects import compared_rows, compared_table
from lockprobe.report.rows import Estimate, Finding, Results, Row
from lockprobe.report.section import Note, Part, Section, Table
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.statistics.conditions.factors import LEVELS, READING_FACTORS
from lockprobe.statistics.conditions.no_feedback import NO_FEEDBACK


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    found = numbers.others.on_factors if numbers.others else ()
    for one in found:
        yield from compared_rows(one, numbers.conditions)
    if effects := [effect for one in found if one.axis not in READING_FACTORS for effect in one.effects]:
        said = f"{sum(one.detectable for one in effects)} of {len(effects)} differences were detected."
        yield Finding(section="factors", kind="answer", text=said, rests_on=("success_difference",))


def _compared(found: Results) -> list[Estimate]:
    rows = [row for row in found.where("success_difference", of="") if row.family.startswith(LEVELS)]
    return [row for row in rows if row.axis not in (*READING_FACTORS, NO_FEEDBACK)]  # these have a section of their own


def _table(found: Results) -> TextTable:
    rows = _compared(found)
    return compared_table(found, rows) if rows else []


_FACTORS = Table("factors", _table)

_NOTE = Note(
    Markup(
        "Success under conditions that differ in one option alone, in the trials finished under both. "
        "<em>Not detected</em> does not show that there is no difference."
    ),
    Markup(
        "Trials of equal repetition and number use common random numbers and are compared in pairs. <i>P</i> is the "
        "larger of two: that of McNemar's exact test (with people: of a permutation) and that of the interval; both "
        "are corrected for all comparisons of the option and for the agents (baselines apart)."
    ),
)


def _show(found: Results) -> Iterator[Part]:
    if rows := _compared(found):
        names = ", ".join(dict.fromkeys(row.axis for row in rows))
        yield Part(f"Options compared: {names}", found.answer_of("factors"), [_FACTORS, _NOTE])


SECTIONS = (Section(name="factors", title="Options compared", rows=_rows, show=_show, tables=(_FACTORS,)),)
