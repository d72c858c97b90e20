"""Optimal actions: how many actions an ideal observer who was told the same would have chosen too."""

from __future__ import annotations

from collections.abc import Iterator

from markupsafe import Markup

from lockprobe.report.format import TextTable
from lockprobe.report.rows import Results, Row
from lockprobe.report.sample_pictures import ABOUT
from lockprobe.report.section import Block, Note, Part, Section, Table
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.report.table_rows import distinct, flips_first, share_of_row, under, varied
from lockprobe.statistics.rationality import ACTIONS, JUDGED, prior_for

_PRIORS = {
    "single-parent": "every joint is free or needs one other joint open",
    "chains": "the joints form a chain that ends in the target",
}

_NAIVE = "naive"
"""The observer, which believes every report."""

_CONTRADICTED = "true reports contradict the prior"


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    for cell in numbers.cells:
        if found := cell.summary.optimal:
            truth = numbers.study.labelled(cell.condition).p == 0
            note = _CONTRADICTED if truth and found.contradicted else ""
            yield from cell.share("optimal_actions", found.share, of=_NAIVE, note=note)
    yield from numbers.answer("optimal_actions", "optimal_actions")


def _table(found: Results) -> TextTable:
    """The share of optimal actions."""
    cells = [cell for cell in flips_first(found) if cell.get("optimal_actions", _NAIVE)]
    table = [["agent", varied(cells), "actions", "optimal"]]
    for cell, _ in distinct(cells):
        row = cell.get("optimal_actions", _NAIVE)
        table.append([cell.label, under(cell, cells), str(row.n if row else 0), share_of_row(row)])
    return table


_TABLE = Table("optimal-actions", _table)


def _show(found: Results) -> Iterator[Part]:
    if found.where("optimal_actions"):
        yield Part("Optimal actions", found.answer_of("optimal_actions"), list(_blocks(found)))


def _blocks(found: Results) -> Iterator[Block]:
    seen = any(fact.about.startswith(ABOUT) for fact in found.facts)
    pictures = (
        "; with pictures, the observer sees the truth without error even if a picture was false, so misreadings count "
        "against the agent"
    )
    contradicted = Markup(
        " <strong>On this box true reports contradict this prior</strong>, so these numbers say little about it."
    )
    joints = len(found.study.get("box", {}).get("joints", ()))
    yield _TABLE
    yield Note(
        "Every action is judged by an ideal observer that receives the agent's reports and believes them, which is "
        "correct at a flip rate of 0. An action is optimal if no other has fewer expected steps to the "
        f"solution{pictures if seen else ''}.",
        Markup("Its prior is that {}.{}").format(
            _PRIORS[prior_for(joints) or "chains"],
            contradicted if any(row.note for row in found.where("optimal_actions")) else "",
        ),
        f"At most the first {JUDGED} trials and {ACTIONS} actions of a condition are judged, and of a trial with an "
        "attempt that broke the rules of the box the actions before it. A condition is not judged where an action was "
        "not the choice, or a report was missing. Intervals are clustered by trial.",
    )


SECTIONS = (Section(name="optimal_actions", title="Optimal actions", rows=_rows, show=_show, tables=(_TABLE,)),)
