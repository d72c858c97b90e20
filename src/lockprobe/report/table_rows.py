"""How tables name what their rows are of, and how they write estimates."""

from __future__ import annotations

from collections.abc import Sequence

from lockprobe.foundation.formatting import NONE, bracketed, percent, range_of, share
from lockprobe.report.format import EVERY
from lockprobe.report.prose import at_dose, condition_words
from lockprobe.report.rows import Cell, Course, Estimate, Results


def share_of_row(row: Estimate | None) -> str:
    """A share in per cent, with its interval where it has one."""
    if row is None or row.low is not None:
        return NONE if row is None else share(row.value, row.low, row.high)
    return percent(row.value, 0)


def points_cell(row: Estimate | None) -> str:
    """A difference with its interval, in points."""
    return NONE if row is None else bracketed(row.value, row.low, row.high)


def steps_cell(row: Estimate) -> str:
    """A difference in steps, with its interval."""
    return bracketed(row.value, row.low, row.high, "{:+.1f}", 1)


def count_of(row: Estimate | None) -> str:
    """How many of how many."""
    return "0 of 0" if row is None else f"{row.count} of {row.n}"


def value_cell(row: Estimate | None, form: str = "{:.2f}") -> str:
    """A number, with its interval in brackets where it has one."""
    return NONE if row is None else bracketed(row.value, row.low, row.high, form, 1)


def at_lowest(found: Results) -> str:
    """Under which reports agents are compared without an effect of false ones, within a sentence."""
    return at_dose(next(iter(found.flip_rates), 0.0))


def over_rates(found: Results) -> str:
    """Over which reports all trials under flip rates are, within a sentence."""
    return "over all flip rates" if found.several_p else at_lowest(found)


def chance_cell(cell: Cell) -> str:
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
