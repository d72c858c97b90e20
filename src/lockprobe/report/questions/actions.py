"""Optimal actions: how many actions an ideal observer who was told the same would have chosen too."""

from __future__ import annotations

from collections.abc import Iterator

from lockprobe.foundation.formatting import MOST_NAMED, percent, range_of
from lockprobe.report.format import TextTable
from lockprobe.report.rows import Cell, Results, Row
from lockprobe.report.section import Note, Part, Section, Table
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.report.table_rows import distinct, flips_first, share_of_row, under, varied
from lockprobe.statistics.rationality import ACTIONS, JUDGED, optimal_actions, prior_for

_PRIORS = {
    "single-parent": "every joint is free or needs one other joint open",
    "chains": "the joints form a chain that ends in the target",
}

_NAIVE = "naive"
"""The observer, which believes every report."""

_CONTRADICTED = "true reports contradict the prior"


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    for cell in numbers.cells:
        if found := optimal_actions(cell.trials, numbers.rules.judged if numbers.broken_rules_said else None):
            share, contradicted = found
            truth = numbers.study.labelled(cell.condition).p == 0
            yield from cell.share("optimal_actions", share, of=_NAIVE, note=_CONTRADICTED * (truth and contradicted))


def _cells(found: Results) -> list[Cell]:
    return [cell for cell in flips_first(found) if cell.get("optimal_actions", _NAIVE)]


def _table(found: Results) -> TextTable:
    cells = _cells(found)
    table = [["agent", varied(cells), "actions", "optimal"]]
    for cell, _ in distinct(cells):
        row = cell.get("optimal_actions", _NAIVE)
        table.append([cell.label, under(cell, cells), str(row.n if row else 0), share_of_row(row)])
    return table


_TABLE = Table("optimal-actions", _table)


def _show(found: Results) -> Iterator[Part]:
    if not (cells := _cells(found)):
        return
    own = [cell for cell in reversed(cells) if cell.agent in found.subjects]
    first = {found.label(cell.agent, cell.modality): cell for cell in own}
    said = [f"{percent(cell.value('optimal_actions', _NAIVE))} {label}" for label, cell in reversed(first.items())]
    prior = _PRIORS[prior_for(max(len(box.get("joints", ())) for box in found.boxes)) or "chains"]
    which = "this box" if len(found.boxes) == 1 else "some of these boxes"
    doubt = f" On {which} true reports contradict this prior, so these numbers say little about it."
    note = Note(
        "An action is optimal if no other has fewer expected steps to the solution for an ideal observer that receives "
        "the agent's reports and believes them, which is correct at a flip rate of 0. Pictures count as read without "
        "error, so misreadings count against the agent.",
        f"Its prior is that {prior}.{doubt * any(row.note for row in found.where('optimal_actions'))}",
        f"At most the first {JUDGED} trials and {ACTIONS} actions of a condition are judged, and of a trial with an "
        "attempt that broke the rules of the box the actions before it. A condition is not judged where an action was "
        "not the choice, or a report was missing. Intervals are clustered by trial.",
    )
    over = [cell.value("optimal_actions", _NAIVE) or 0.0 for cell in first.values()]
    shown = "; ".join(said) if len(said) <= MOST_NAMED else f"{range_of(min(over), max(over))} for {len(over)} agents"
    answer = f"Under the first condition: {shown}." if said else ""
    yield Part("Optimal actions", answer, [_TABLE, note])


SECTIONS = (Section(name="optimal_actions", title="Optimal actions", rows=_rows, show=_show, tables=(_TABLE,)),)
