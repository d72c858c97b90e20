"""The page of a report, made from its results and figures and from nothing else.

What comes from agents, models and box files is untrusted: it is escaped, without characters that hide or reorder
others. It runs one script, our own (``templates/report.js``), which its policy names by its hash.
"""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from importlib.resources import files
from typing import Any, NamedTuple
from urllib.parse import quote

from lockprobe.foundation.left_out import section
from lockprobe.report.format import Entry, texts
from lockprobe.report.questions import all_sections
from lockprobe.report.rendering import own_markup, rendered
from lockprobe.report.rows import Results
from lockprobe.report.section import Block, Figure, Part, Section, Table, Template


class Image(NamedTuple):
    """A figure as a page embeds it: a data URI, and its width in pixels."""

    source: str
    width: int


def image(svg: bytes) -> Image:
    """A figure of Matplotlib for a page, without what only a file of its own needs; to a hundredth of a point."""
    small = re.sub(r"<metadata>.*?</metadata>|<!--.*?-->|<\?xml.*?\?>|<!DOCTYPE.*?>", "", svg.decode(), flags=re.DOTALL)
    wide = re.search(r'width="([\d.]+)pt"', small)
    text = re.sub(r"(?<!scale\()(\b\d+\.\d\d)\d+", r"\1", re.sub(r"\s+", " ", small)).replace('"', "'")
    source = quote(text, safe=" !$&'()*+,-./:;=?@[]^_`{|}~")
    return Image(f"data:image/svg+xml,{source}", round(float(wide[1]) * 96 / 72) if wide else 0)


@dataclass
class Page:
    """What the template of a page reads.

    Attributes:
        found: The results.
        drawn: Figure -> how the page embeds it.
        photographs: Pictures that agents saw, by the names of their files.
        trials: The data of the trial explorer.
        made: When it was made, of a study with open trials.
    """

    found: Results
    drawn: Mapping[str, Image] = field(default_factory=dict)
    photographs: Mapping[str, str] = field(default_factory=dict)
    trials: str = ""
    made: str = ""

    @cached_property
    def parts(self) -> list[Part]:
        """Its parts."""
        return parts_of(self.found)

    def text(self) -> str:
        """The page, with our one script and its hash; if even its frame cannot be made, one that says so."""
        script = files("lockprobe.report").joinpath("templates/report.js").read_text(encoding="utf-8")
        digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
        return section(
            "Page report.html",
            lambda: rendered("report", found=self.found, page=self, script=script, script_hash=f"sha256-{digest}"),
            lambda: rendered("left_out", found=self.found, page="report"),
        )

    def cells(self, table: Table) -> Sequence[Sequence[Entry]]:
        """The rows of a table, made once."""
        if table not in self._made:
            self._made[table] = cells_of(table, self.found)
        return self._made[table]

    @cached_property
    def _made(self) -> dict[Table, Sequence[Sequence[Entry]]]:
        return {}

    def template(self, block: Template) -> Any:
        """A block that has a template of its own."""
        return own_markup(rendered(block.name, found=self.found, page=self, **block.values))

    def written(self, part: Part) -> Any:
        """The blocks of a part; a line that says so if they cannot be written."""
        missing = '<p class="off">This section could not be written; the top of the page says why.</p>'
        write = partial(rendered, "written", blocks=list(part.blocks), page=self)
        return own_markup(section(part.heading, write, lambda: missing))


def parts_of(found: Results) -> list[Part]:
    """The parts of the page, each named after its section."""
    return [part for one in all_sections() for part in section(one.title, partial(_shown, one, found), list[Part])]


def _shown(one: Section, found: Results) -> list[Part]:
    return [
        replace(part, name=part.name or one.name, blocks=section(one.title, partial(list, part.blocks), list[Block]))
        for part in one.show(found)
    ]


def figures_of(parts: Iterable[Part]) -> list[Figure]:
    """The figures that parts show."""
    return [block for part in parts for block in part.blocks if isinstance(block, Figure)]


def tables_of(found: Results) -> dict[str, list[list[str]]]:
    """The tables of all sections by name, as text; one that cannot be made says so."""
    return {table.name: texts(cells_of(table, found)) for one in all_sections() for table in one.tables}


def cells_of(table: Table, found: Results) -> Sequence[Sequence[Entry]]:
    """The rows of a table; one that says so if they cannot be made."""
    return section(f"Table {table.name}", partial(table.cells, found), lambda: [["This table could not be made."]])
