"""A factorial design: what each factor does to misreading and to success."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from markupsafe import Markup

from lockprobe.foundation.formatting import p_cell
from lockprobe.report.format import TextTable
from lockprobe.report.prose.factorial import factor_said, factorial_said
from lockprobe.report.rows import Estimate, Finding, Results, Row
from lockprobe.report.section import Block, Caption, Figure, Heading, Note, Part, Section, Table, Text
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.report.table_rows import points_cell
from lockprobe.statistics.factorial.effects import FactorialEffects

_FAMILY = "factors"


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    for found in numbers.others.factorials if numbers.others else ():
        own: dict[str, Any] = {"agent": found.agent, "modality": found.design.modality, "clusters": found.blocks}
        n = found.blocks * len(found.design.runs)
        levels = {name: f"{name}={high}" for name, (_, high) in found.design.levels.items()}
        for measure, mean in found.means.items():
            yield Estimate(quantity="factorial_mean", **own, of=measure, value=mean, n=n)
        for one in found.effects:
            of = own | {"axis": levels[one.factor], "of": one.measure, "n": n}
            tested: dict[str, Any] = {
                "p_value": one.p_value,
                "family": _FAMILY,
                "corrected_for": len(found.design.factors),
            }
            ends: dict[str, Any] = {"value": one.value, "low": one.low, "high": one.high}
            yield Estimate(quantity="factor_effect", **of, unit="points", **ends, **tested, test="Student over blocks")
        yield _answer(found)


def _answer(found: FactorialEffects) -> Finding:
    return Finding(
        section="factorial",
        kind="answer",
        agent=found.agent,
        modality=found.design.modality,
        text=factorial_said(found),
        rests_on=("factorial_mean", "factor_effect"),
    )


def _agents(found: Results) -> list[Estimate]:
    """Every agent with a factorial design, by its mean misreading, or else its success."""
    rows = {(row.agent, row.modality): row for row in reversed(found.where("factorial_mean"))}
    return list(reversed(rows.values()))


def _table(found: Results) -> TextTable:
    head = ["agent", "of", "factor", "change, points", "P"]
    rows = found.where("factor_effect")
    return [head] * bool(rows) + [
        [row.agent, row.of, factor_said(row.axis), points_cell(row), p_cell(row.p_value)] for row in rows
    ]


_TABLE = Table("factorial", _table, numeric_from=3)

_FIGURE = Figure(
    "factorial",
    "What each factor does to misreading and to success",
    Caption(
        "The named level of every factor minus its level in the plain scene, in points, over trials of equal luck. "
        "Filled: detected.",
        "Brackets are 95 % intervals over blocks, corrected for the number of factors.",
    ),
    draw="lockprobe.report.figures.factorial:factorial",
    applies=lambda found: bool(_agents(found)),
)

_NOTE = Note(
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


def _show(found: Results) -> Iterator[Part]:
    if agents := _agents(found):
        blocks: list[Block] = [_FIGURE]
        for row in agents:
            said = found.said("factorial", "answer", agent=row.agent, modality=row.modality)
            blocks += [*([Heading(row.agent, code=True)] if len(agents) > 1 else []), *map(Text, said)]
        answer = found.said("factorial", "answer", agent=agents[0].agent, modality=agents[0].modality)[0]
        yield Part("Which features matter?", answer, [*blocks, _TABLE, _NOTE])


SECTIONS = (
    Section(
        name="factorial",
        title="Factors of a factorial design",
        rows=_rows,
        show=_show,
        tables=(_TABLE,),
        figures=(_FIGURE,),
    ),
)
