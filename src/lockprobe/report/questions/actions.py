"""Optimal actions: how many actions an ideal observer who was told the same would have chosen too."""

from __future__ import annotations

from collections.abc import Iterator

from lockprobe.foundation.formatting import MOST_NAMED, percent, range_of
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.prose import condition_words
from lockprobe.report.rows import Cell, Results, Row
from lockprobe.report.section import Note, Part, Section
from lockprobe.statistics.rationality import ACTIONS, JUDGED, optimal_actions, prior_for

_PRIORS = {
    "single-parent": "every joint is free or needs one other joint open",
    "chains": "the joints form a chain that ends in the target",
}

_NAIVE = "naive"
"""The observer, which believes every report."""

_CONTRADICTED = "true reports contradict the prior"


def _rows(numbers: OpenedStudy) -> Iterator[Row]:
    for cell in numbers.cells:
        if found := optimal_actions(cell.trials, numbers.rules.judged if numbers.broken_rules_said else None):
            share, contradicted = found
            truth = numbers.study.labelled(cell.condition).p == 0
            yield from cell.share("optimal_actions", share, of=_NAIVE, note=_CONTRADICTED * (truth and contradicted))


def _show(found: Results) -> Iterator[Part]:
    cells = [cell for cell in found.cells if cell.get("optimal_actions", _NAIVE)]
    if not cells:
        return
    first: dict[str, Cell] = {}
    for cell in cells:
        if cell.agent in found.subjects:
            first.setdefault(found.player(cell.agent, cell.modality).label, cell)
    over = {label: cell.value("optimal_actions", _NAIVE) or 0.0 for label, cell in first.items()}
    under = {condition_words(found)[cell.condition] for cell in first.values()}
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
    said = ", ".join(f"{percent(share)} for {label}" for label, share in over.items())
    if len(over) > MOST_NAMED:
        said = f"{range_of(min(over.values()), max(over.values()))} for {len(over)} agents"
    where = under.pop() if len(under) == 1 else "under the first condition of each"
    answer = f"Share of actions that an ideal observer would have chosen too, {where}: {said}." if said else ""
    yield Part("How many actions are optimal?", answer, [note])


SECTIONS = (Section("optimal_actions", "Optimal actions", _rows, _show),)
