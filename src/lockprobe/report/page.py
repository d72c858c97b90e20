"""The page of a report, made from its results and figures and from nothing else.

What comes from agents, models and box files is untrusted: it is escaped, without characters that hide or reorder
others. It runs one script, our own (``templates/report.js``), which its policy names by its hash.
"""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, cached_property, partial
from importlib.resources import files
from typing import Any

from lockprobe.foundation.left_out import section
from lockprobe.report.format import TextTable
from lockprobe.report.questions import all_sections
from lockprobe.report.rendering import rendered, with_axis
from lockprobe.report.rows import Estimate, Results
from lockprobe.report.section import Block, Caption, Figure, Part, Section, Table, Template, nested
from lockprobe.report.svg import Image

Pictures = Mapping[str, Image]
"""Figure -> how pages embed it."""


@dataclass
class Page:
    """What the template of a page reads.

    Attributes:
        found: The results.
        drawn: The figures.
        photographs: Pictures that agents saw, by the names of their files.
        trials: The data of the trial explorer.
        made: When it was made, of a study with open trials.
    """

    found: Results
    drawn: Pictures = field(default_factory=dict)
    photographs: Mapping[str, str] = field(default_factory=dict)
    trials: str = ""
    made: str = ""

    def cells(self, table: Table) -> TextTable:
        """The rows of text of a table."""
        if table not in self._tables:
            self._tables[table] = _cells(table, self.found)
        return self._tables[table]

    @cached_property
    def _tables(self) -> dict[Table, TextTable]:
        """Tables that were asked for, of which two may have one name."""
        return {}

    @cached_property
    def parts(self) -> list[Part]:
        """Its parts."""
        return parts_of(self.found)

    def text(self) -> str:
        """The page; if even its frame cannot be made, one that says so."""
        return section(
            "Page report.html",
            lambda: rendered("report", found=self.found, page=self, parts=self.parts),
            lambda: rendered("left_out", found=self.found, page="report"),
        )

    def plots(self, table: Table) -> list[tuple[Estimate | None, float]]:
        """The differences that stand beside the rows of a table; see :func:`with_axis`."""
        return with_axis([] if table.drawn is None else list(table.drawn(self.found)))

    def image(self, figure: str) -> Image | None:
        """The figure of this name, as pages embed it; None if it was not drawn."""
        return self.drawn.get(figure)

    def caption(self, figure: Figure) -> Caption:
        """Its caption."""
        return figure.caption if isinstance(figure.caption, Caption) else figure.caption(self.found)

    def template(self, block: Template) -> Any:
        """A block that has a template of its own."""
        return _own(rendered(block.name, found=self.found, page=self, **block.values))

    def written(self, part: Part) -> Any:
        """The blocks of a part; a line that says so if they cannot be written."""
        missing = '<p class="off">This section could not be written; the top of the page says why.</p>'
        write = lambda: _own(rendered("written", blocks=list(part.blocks), page=self))  # noqa: E731
        return section(part.heading, write, lambda: _own(missing))

    @property
    def trials_data(self) -> Any:
        """The trials as JSON that no browser runs."""
        return _own(self.trials)

    @property
    def script(self) -> Any:
        """The program of the page."""
        return _own(_script())

    @property
    def script_hash(self) -> str:
        """Its hash as a source of a content security policy."""
        return f"sha256-{base64.b64encode(hashlib.sha256(_script().encode()).digest()).decode()}"


@cache
def _script() -> str:
    return files("lockprobe.report").joinpath("templates/report.js").read_text(encoding="utf-8")


def _own(text: str) -> Any:
    """Our own markup, or JSON without ``<``."""
    from markupsafe import Markup

    return Markup(text)  # noqa: S704  a template's own output


def parts_of(found: Results) -> list[Part]:
    """The parts of the page, each named after its section."""
    return [part for one in all_sections() for part in _shown(one, found)]


def _shown(one: Section, found: Results) -> list[Part]:
    def show() -> list[Part]:
        return [
            replace(
                part,
                name=part.name or one.name,
                blocks=section(one.title, partial(list, part.blocks), list[Block]),
            )
            for part in one.show(found)
        ]

    return section(one.title, show, list[Part])


def figures_of(parts: Iterable[Part]) -> list[Figure]:
    """The figures that parts show."""
    return [block for part in parts for block in nested(part.blocks) if isinstance(block, Figure)]


def tables_of(found: Results) -> dict[str, TextTable]:
    """The tables of all sections by name; one that cannot be made says so."""
    return {table.name: _cells(table, found) for one in all_sections() for table in one.tables}


def _cells(table: Table, found: Results) -> TextTable:
    missing: Callable[[], TextTable] = lambda: [["This table could not be made."]]  # noqa: E731
    return section(f"Table {table.name}", partial(_checked_cells, table, found), missing)


def _checked_cells(table: Table, found: Results) -> TextTable:
    """The rows of text of a table.

    Raises:
        TypeError: If a cell is no text, or rows have different numbers of cells.
    """
    rows = table.cells(found)
    for row in rows:
        if len(row) != len(rows[0]) or not all(isinstance(cell, str) for cell in row):
            raise TypeError(f"expected {len(rows[0])} cells of text in every row of table {table.name}, not {row}")
    return rows
