"""A section of a report: one question, with the rows that answer it and what the page shows of them.

A section works in two passes. ``rows`` makes rows from the numbers of a study; ``show`` makes blocks of a page from the
rows of *all* sections, and from nothing else.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import ClassVar

from lockprobe.report.format import TextTable
from lockprobe.report.rows import Estimate, Results, Row
from lockprobe.report.study_numbers import StudyNumbers


@dataclass(frozen=True, slots=True)
class Caption:
    """What a figure or table shows and how it was computed, at most two sentences each, and further notes."""

    shown: str
    computed: str = ""
    more: str = ""


@dataclass(frozen=True, slots=True)
class Text:
    """A paragraph. A plain string is escaped; ``Markup`` is not. ``style`` is a class of the page."""

    block: ClassVar[str] = "text"
    text: str
    style: str = ""


@dataclass(frozen=True, slots=True)
class Heading:
    """A heading within a section; ``code`` sets it as a spec."""

    block: ClassVar[str] = "heading"
    text: str
    code: bool = False


@dataclass(frozen=True, slots=True)
class Note:
    """What a table shows and how it was computed; ``lead`` sets it in full size, above what it explains."""

    block: ClassVar[str] = "note"
    shown: str
    computed: str = ""
    more: str = ""
    lead: bool = False


@dataclass(frozen=True, slots=True)
class Cells:
    """A table as rows of text, the first with the names of the columns.

    Attributes:
        rows: The text.
        numeric_from: The first column of numbers, which are not broken into lines.
    """

    block: ClassVar[str] = "cells"
    rows: TextTable
    numeric_from: int = 2


@dataclass(frozen=True, slots=True)
class Table:
    """A table of the report: a file in ``tables/``, and a block where a page shows it.

    Attributes:
        name: Name of its files.
        cells: Makes its rows of text from the results; no file is written where it gives none.
        numeric_from: The first column of numbers.
        drawn: The difference of each row, which the page draws beside it, on one axis for all; None for a row without.
    """

    block: ClassVar[str] = "table"
    name: str
    cells: Callable[[Results], TextTable]
    numeric_from: int = 2
    drawn: Callable[[Results], Sequence[Estimate | None]] | None = None


@dataclass(frozen=True, slots=True)
class Figure:
    """A figure of the report: files in ``figures/``, and a block where a page shows it.

    Attributes:
        name: Name of its files.
        alt: What it shows, for people who do not see it.
        caption: Its caption, or what makes it from the results.
        draw: ``module:function`` that draws it from the results, imported when it is drawn; it returns a figure of
            matplotlib, or None where there is nothing to draw.
        applies: Whether there is something to draw.
        arguments: Further arguments of that function.
        slide: Whether it is written as PNG as well as SVG, for slides.
    """

    block: ClassVar[str] = "figure"
    name: str
    alt: str
    caption: Caption | Callable[[Results], Caption]
    draw: str = ""
    applies: Callable[[Results], bool] = lambda found: True
    arguments: tuple[object, ...] = ()
    slide: bool = False


@dataclass(frozen=True, slots=True)
class Detail:
    """Blocks that open in place within a part: long tables and further figures."""

    block: ClassVar[str] = "detail"
    summary: str
    blocks: Sequence[Block]


@dataclass(frozen=True, slots=True)
class Listed:
    """A list of sentences."""

    block: ClassVar[str] = "listed"
    items: Sequence[str]


@dataclass(frozen=True, slots=True)
class Picture:
    """Pictures that an agent saw, by the names of their files, with what it was told."""

    block: ClassVar[str] = "picture"
    files: Sequence[str]
    alt: str
    caption: str


@dataclass(frozen=True, slots=True)
class Template:
    """A block with a template of its own, in ``templates/``, which reads the results and these values."""

    block: ClassVar[str] = "template"
    name: str
    values: dict[str, object] = field(default_factory=dict)


Block = Text | Heading | Note | Cells | Table | Figure | Detail | Listed | Picture | Template
"""What a page is made of."""


def nested(blocks: Iterable[Block]) -> Iterator[Block]:
    """Blocks, each followed by those within it."""
    for block in blocks:
        yield block
        yield from nested(block.blocks if isinstance(block, Detail) else ())


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


@dataclass(frozen=True, slots=True, kw_only=True)
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
    rows: Callable[[StudyNumbers], Iterable[Row]] = lambda numbers: ()
    show: Callable[[Results], Iterable[Part]] = lambda found: ()
    tables: tuple[Table, ...] = ()
    figures: tuple[Figure, ...] = ()
