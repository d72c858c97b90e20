"""What names the rows of tables: agents, and the flip rate or the condition that tells their rows apart."""

from __future__ import annotations

from collections.abc import Sequence

from lockprobe.foundation.formatting import NONE, range_of
from lockprobe.report.format import EVERY
from lockprobe.report.prose import condition_words
from lockprobe.report.rows import Cell, Course, Results


def chance_said(cell: Cell) -> str:
    """The loop rate of random actions, from uniform to without immediate repeats."""
    low, high = (cell.value("loop_rate", of) for of in ("uniform", "no-repeat"))
    return NONE if low is None or high is None else range_of(low, high)


def by_conditions(cells: Sequence[Cell]) -> bool:
    """Whether flip rates do not tell the cells apart: then all go by the names of their conditions."""
    rates = {(cell.label, cell.p) for cell in cells}
    return None in {p for _, p in rates} or len(rates) < len({(cell.label, cell.condition) for cell in cells})


def varied(cells: Sequence[Cell]) -> str:
    """What tells the rows of one agent apart."""
    return "condition" if by_conditions(cells) else "flip rate"


def under(cell: Cell, among: Sequence[Cell]) -> str:
    """The flip rate or the condition of a row."""
    return condition_words(cell.found)[cell.condition] if by_conditions(among) else f"{cell.p:g}"


def distinct(cells: Sequence[Cell]) -> list[tuple[Cell, str]]:
    """Cells with their flip rate or name; of an agent that plays the same at every flip rate only the first."""
    once = {(cell.agent, cell.modality): cell for cell in reversed(cells) if cell.same_at_every_p}
    return [
        (cell, EVERY if cell.same_at_every_p else under(cell, cells))
        for cell in cells
        if not cell.same_at_every_p or once[cell.agent, cell.modality] is cell
    ]


def played_subjects(found: Results) -> list[Course]:
    """The agents that the study is about, over flip rates; all agents if none of these has an ended trial."""
    played = [course for course in found.courses() if course.played]
    return [course for course in played if course.subject] or played
