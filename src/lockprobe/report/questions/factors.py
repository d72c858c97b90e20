"""Factors: options that are no numbers, each level against the first; and the effects of a factorial design."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from markupsafe import Markup

from lockprobe.foundation.formatting import capital, listed
from lockprobe.foundation.grouping import grouped
from lockprobe.report.format import Entry, entry_text, tested
from lockprobe.report.questions.conditions import compared_rows, detected_said
from lockprobe.report.rows import Estimate, Results, Row
from lockprobe.report.section import Note, Part, Section, Table
from lockprobe.report.study_numbers import StudyNumbers, measured_row
from lockprobe.statistics.contrast import against_first
from lockprobe.statistics.factorial import factorial_effects


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    if not numbers.study.of_flips:
        yield from compared_rows(against_first(numbers.by_name, numbers.design.factors, numbers.design), numbers)


def _of_factorial(numbers: StudyNumbers) -> Iterator[Row]:
    cells = {(cell.agent, cell.condition): cell.trials for cell in numbers.cells}
    for found in () if numbers.study.of_flips else factorial_effects(cells, numbers.design):
        yield measured_row(
            "factor_effect", found.change, agent=found.agent, modality=found.modality, of=found.measure,
            axis=f"{found.factor}={found.level}", unit="points", family="factors", corrected_for=found.factors,
            test="Student over blocks",
        )  # fmt: skip


def factors_said(rows: Sequence[Estimate]) -> str:
    """Which factors change what, for any agent."""
    agents = len({(row.agent, row.modality) for row in rows})
    return f"{capital(f'for at least one of {agents} agents, ' * (agents > 1) + _changes_said(rows, _name))}."


def _changes_said(rows: Sequence[Estimate], called: Callable[[Estimate], str]) -> str:
    """What each measure was detected to change with, the largest effect first."""
    said = []
    for measure, own in grouped(rows, lambda row: row.of).items():
        clear = sorted((row for row in own if row.detected), key=lambda row: -abs(row.value or 0.0))
        names = [*dict.fromkeys(map(called, clear))]
        said.append(f"{measure} changes with {listed(names)}" if names else f"no change of {measure} was detected")
    return "; ".join(said)


def _name(row: Estimate) -> str:
    """A factor with its named level, without the plant whose option it is."""
    return row.axis.removeprefix("plant.")


def _factorial(found: Results) -> list[list[Entry]]:
    head: list[Entry] = ["agent", "of", "factor", "change, points", "P", "conclusion"]
    rows: list[list[Entry]] = [[one.agent, one.of, _name(one), *tested(one)] for one in found.where("factor_effect")]
    return [head, *rows] if rows else []


FACTORIAL = Table("factorial", _factorial, 3, drawn="change, points")

_FRACTION = Note(
    Markup(
        "Every factor has two levels, and the study plays a balanced part of their combinations (<em>fractional "
        "factorial</em>), so that each factor is compared in all trials. With eight factors in 16 scenes no effect of "
        "a factor is mixed with that of another or of an interaction of two."
    ),
    Markup(
        "The effect is a mean over blocks. Its interval is Student\N{RIGHT SINGLE QUOTATION MARK}s, corrected for the "
        "number of factors (Bonferroni); <i>P</i> is corrected too (Holm)."
    ),
    Markup(
        "<em>Misreading</em> is the share of statements about the last action that contradict what happened. What the "
        "scripted <code>viewer</code> misreads, at the acuity that the pictures need, is the floor of these pictures."
    ),
)


def _show_factorial(found: Results) -> Iterator[Part]:
    if rows := found.where("factor_effect"):
        agents = grouped(rows, lambda row: (row.agent, row.modality)).values()
        sized: Callable[[Estimate], str] = lambda row: f"{_name(row)} ({entry_text(row)} points)"  # noqa: E731
        said = [f"{own[0].agent}: {_changes_said(own, sized)}." for own in agents]
        yield Part("Which features matter?", detected_said(rows, "effects"), [said, FACTORIAL, _FRACTION], "factorial")


SECTIONS = (
    Section(
        name="factorial",
        title="Factors of a factorial design",
        rows=_of_factorial,
        show=_show_factorial,
        tables=(FACTORIAL,),
    ),
    Section(name="factors", title="Options compared", rows=_rows),
)
