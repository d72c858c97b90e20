"""What a page shows of a study that is unfinished, was extended, or stops when it is decided.

Success and its differences are given as they hold at every look. All other tests hold for one look, at a number of
trials that was planned before and is played. So their P values are left out, and so are sentences that judge by them.
"""

from __future__ import annotations

from collections.abc import Iterable

from markupsafe import Markup

from lockprobe.report.rows import Estimate, Results, Row
from lockprobe.report.section import Note

_ONE_LOOK = "its P value holds for one look, when all planned trials are played"

_HOW = Markup(
    "Interval and <i>P</i> hold at every look: a confidence sequence and an e-process of the mean over blocks, by "
    "betting. They are corrected by closed testing for the conditions of a family, and for the number of agents."
)


def note_at(found: Results, note: Note) -> Note:
    """The note on tests, as it is where they hold at every look."""
    return Note(note.shown, _HOW) if found.progress.every_look else note


def at_every_look(rows: Iterable[Row]) -> list[Row]:
    """The rows without P values that hold for one look alone."""
    return [
        row.model_copy(update={"p_value": None, "test": "", "note": "; ".join(filter(None, (row.note, _ONE_LOOK)))})
        if isinstance(row, Estimate) and row.p_value is not None and "e-process" not in row.test
        else row
        for row in rows
    ]
