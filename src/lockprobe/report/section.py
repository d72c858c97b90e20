"""A section of a report: one question, with the rows that answer it and what the page shows of them.

A section works in two passes. ``rows`` makes rows from the numbers of a study; ``show`` makes parts of the page from
the rows of *all* sections, and from nothing else.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

from markupsafe import Markup

from lockprobe.foundation.formatting import NONE
from lockprobe.report.format import Entry, texts
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.rows import Results, Row

Lines = Iterator[Sequence[Entry]]
"""The rows of a table, the first with the names of columns."""


@dataclass(frozen=True, slots=True)
class Note:
    """What a figure or a table shows and how it was computed, at most two sentences each, and further notes."""

    block: ClassVar[str] = "note"
    shown: str
    computed: str = ""
    more: str = ""


BY_BETTING = "hold at every look: a confidence sequence and an e-process of the mean over blocks, by betting."
"""What interval and P value of a change do, of a study whose numbers hold at every look."""

_HOW = Markup(
    "Interval and <i>P</i> {} They are corrected by closed testing for the conditions of a family, and for the number "
    "of agents."
).format(BY_BETTING)


def note_at(found: Results, note: Note) -> Note:
    """The note on tests, as it is where they hold at every look."""
    return Note(note.shown, _HOW) if found.progress.every_look else note


@dataclass(frozen=True, slots=True)
class Table:
    """A table of the report: a file in ``tables/``, and a block where a page shows it.

    Attributes:
        name: Name of its file; empty for one that only the page has.
        lines: Makes its rows from the results, the first with the names of columns.
        numeric_from: The first column of numbers, which are not broken into lines.
        drawn: The column whose differences the page draws too, all on one axis.
        rare: Columns that are left out where they are empty, or the same in all of several rows.
    """

    block: ClassVar[str] = "table"
    name: str
    lines: Callable[[Results], Iterable[Sequence[Entry]]]
    numeric_from: int = 2
    drawn: str = ""
    rare: tuple[str, ...] = ()

    def cells(self, found: Results) -> Sequence[Sequence[Entry]]:
        """Its rows, the first with the names of columns; nothing without any other, and then no file is written."""
        return without_rare(self.lines(found), self.rare)


def without_rare(lines: Iterable[Sequence[Entry]], rare: Sequence[str]) -> Sequence[Sequence[Entry]]:
    """The rows of a table without those of these columns that say nothing; without any row but the first, none."""
    table = [*lines]
    if len(table) < 2:
        return []
    columns, several = zip(*texts(table), strict=True), len(table) > 2
    alike = {
        i
        for i, (name, *cells) in enumerate(columns)
        if name in rare and ({*cells} == {NONE} or (several and len({*cells}) == 1))
    }
    return [[entry for i, entry in enumerate(row) if i not in alike] for row in table]


@dataclass(frozen=True, slots=True)
class Figure:
    """A figure of the report: a file in ``figures/``, and a block where a page shows it.

    Attributes:
        name: Name of its file.
        alt: What it shows, for people who do not see it.
        caption: Makes its caption from the results.
        draw: Draws it from the results with what it imports itself: a figure of Matplotlib, or None without anything
            to draw.
        applies: Whether there is something to draw.
    """

    block: ClassVar[str] = "figure"
    name: str
    alt: str
    caption: Callable[[Results], Note]
    draw: Callable[[Results], Any]
    applies: Callable[[Results], bool] = lambda found: True


@dataclass(frozen=True, slots=True)
class Template:
    """A block with a template of its own, in ``templates/``, which reads the results and these values."""

    block: ClassVar[str] = "template"
    name: str
    values: dict[str, Any] = field(default_factory=dict)


Block = str | Sequence[str] | Note | Table | Figure | Template
"""What a page is made of: a paragraph (escaped, but for ``Markup``), a list of sentences, or one of these."""


@dataclass(frozen=True, slots=True)
class Part:
    """A part of a page that opens in place.

    Attributes:
        heading: Its heading.
        answer: Its answer in one sentence, beside the heading.
        blocks: What it holds.
        name: Its anchor; that of the section if empty.
    """

    heading: str
    answer: str
    blocks: Iterable[Block]
    name: str = ""


@dataclass(frozen=True, slots=True)
class Section:
    """One question of a report.

    Attributes:
        name: Its anchor on the page, and its name in messages.
        title: What a reader would call it.
        rows: Makes its rows from the numbers of a study.
        show: Makes its parts of the page from all rows; none where it does not apply.
        tables: Its tables. Those that ``show`` leaves out are written too.
        figures: Its figures. Those that ``show`` gives are drawn.
    """

    name: str
    title: str
    rows: Callable[[OpenedStudy], Iterable[Row]] = lambda numbers: ()
    show: Callable[[Results], Iterable[Part]] = lambda found: ()
    tables: tuple[Table, ...] = ()
    figures: tuple[Figure, ...] = ()
