"""How differences developed with the blocks, at which block each was decided, and what was played."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from lockprobe.foundation.formatting import NONE
from lockprobe.report.format import TextTable
from lockprobe.report.prose.stopping import decided_said
from lockprobe.report.rows import Curve, Estimate, Results, Row
from lockprobe.report.section import Caption, Figure, Note, Part, Section, Table
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.report.table_rows import points_cell
from lockprobe.statistics.sequential.contrasts import AtEveryLook

_HALVES = ("difference_first_half", "difference_second_half")


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    until = numbers.study.until
    for agent, own in numbers.decisions.items():
        for one in own:
            name: dict[str, Any] = {"agent": agent, "of": one.question.name}
            yield from _course(name, one.course)
            if not one.question.of_share and one.course.n > 1:
                for half, value in zip(_HALVES, one.course.halves, strict=True):
                    yield Estimate(quantity=half, **name, unit="points", n=one.course.n, value=value)
            if one.at is not None and until is not None:
                said = decided_said(one.verdict, until.points)
                yield Estimate(quantity="decided_at_block", **name, unit="blocks", value=one.at, note=said)
    if not until and numbers.opened.every_look:
        yield from _of_differences(numbers)


def _of_differences(numbers: StudyNumbers) -> Iterator[Row]:
    """The differences of a study that is unfinished or was extended."""
    axes = [(agent.agent, one, agent) for agent in numbers.flips.agents for one in agent.inference.difference.at]
    for agent, one, of in axes:
        names = {condition.dose: condition.name for condition in of.conditions}
        if one.course:
            yield from _course({"agent": agent, "modality": of.modality, "of": names[one.dose]}, one.course)
    for found in numbers.others.effects if numbers.others else ():
        for effect in found.effects:
            if course := effect.difference.course:
                name = {"agent": found.agent, "modality": found.modality, "of": effect.condition}
                yield from _course(name, course)


def _course(name: dict[str, Any], course: AtEveryLook) -> Iterator[Row]:
    if not course.n:
        return
    yield Estimate(
        quantity="difference_by_block", **name, unit="points", n=course.n, value=course.value, low=course.low,
        high=course.high,
    )  # fmt: skip
    yield Curve(
        quantity="difference_by_block",
        **name,
        axis="block",
        x=tuple(course.blocks.tolist()),
        value=tuple(course.means.tolist()),
        low=tuple(course.lows.tolist()),
        high=tuple(course.highs.tolist()),
        n=course.n,
    )


def _table(found: Results) -> TextTable:
    rows = found.where("difference_by_block")
    stops = "until" in found.study
    head = ["agent", "difference", "blocks", "estimate, points"]
    head += ["first half", "second half", "decided", "at block"] if stops else []
    table = [head]
    for row in rows:
        decided = found.get("decided_at_block", agent=row.agent, of=row.of)
        said = [points_cell(found.get(half, agent=row.agent, of=row.of)) for half in _HALVES]
        said += [decided.note, f"{decided.value:.0f}"] if decided else ["open", NONE]
        table.append([row.agent, row.of, str(row.n), points_cell(row), *(said if stops else [])])
    return table if rows else []


_TABLE = Table("stopping", _table, numeric_from=2)


def _caption(found: Results) -> Caption:
    until = found.study.get("until")
    dotted = f" Dotted: ±{100 * until['points']:g} points." if until else ""
    if found.where("decided_at_block"):
        dotted += " The vertical line marks the block with which it was decided."
    return Caption(
        "Success under each condition minus success under the control after every block, with the interval that holds "
        f"at every look.{dotted}",
        "Intervals are confidence sequences of the mean by betting; several differences of an agent are corrected by "
        "closed testing.",
    )


_FIGURE = Figure(
    "stopping",
    "Estimate and interval after every block, a panel for each difference",
    _caption,
    draw="lockprobe.report.figures.stopping:stopping",
    applies=lambda found: bool(found.where("difference_by_block")),
)


_DRIFT = " The rule assumes that an effect does not drift while the study runs: compare the two halves of the blocks."

_GROWING = "Every difference and its interval, as the trials came in."


def _show(found: Results) -> Iterator[Part]:
    rows = found.where("difference_by_block")
    if not rows:
        return
    decided, parts = len(found.where("decided_at_block")), any(row.of == "total" for row in rows)
    stops = "until" in found.study
    answer = f"{decided} of {len(rows)} differences are decided." if stops else _GROWING
    note = Note(
        "A statement that is made once stays: intervals lie within those before, and P values are the smallest so far.",
        "Blocks count in the order in which they were planned, up to the first that is still open. In at most 5 % of "
        f"studies {'a statement on a total effect' if parts else 'one of these statements'} is false at any look."
        f"{' Contrasts of arms have levels of their own, as the section on them says.' * parts}{_DRIFT * stops}",
    )
    yield Part("Differences block by block", answer, [_FIGURE, _TABLE, note])


SECTIONS = (
    Section(
        name="stopping",
        title="Differences block by block",
        rows=_rows,
        show=_show,
        tables=(_TABLE,),
        figures=(_FIGURE,),
    ),
)
