"""Every file that a report writes: numbers, figures, tables, and one self-contained page.

Tables, figures and the page are made from what ``results.json`` holds and from nothing else; the trial explorer and the
pictures that agents saw come from the records. Equal records give equal files; only the page of a study with open
trials says when it was made.

What comes from agents, models and box files is untrusted: it is escaped, without characters that hide or reorder
others. The page runs one script, our own (``templates/report.js``), which its policy names by its hash.
"""

from __future__ import annotations

import base64
import gc
import hashlib
import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from importlib.resources import files
from pathlib import Path
from urllib.parse import quote

from markupsafe import Markup
from threadpoolctl import threadpool_limits

from lockprobe.foundation.formatting import count, time_said
from lockprobe.foundation.storage.atomic_file import make_directory, refuse_links, write_file
from lockprobe.report.format import Entry, as_csv
from lockprobe.report.left_out import LeftOutSection, leaving_out, section
from lockprobe.report.opened import OpenedStudy, open_study
from lockprobe.report.questions import all_sections
from lockprobe.report.questions.seen import embedded
from lockprobe.report.questions.trials import explorer_data
from lockprobe.report.rendering import own_markup, rendered
from lockprobe.report.results import ONE_THREAD, results_of
from lockprobe.report.rows import Results
from lockprobe.report.section import Block, Figure, Part, Table, Template
from lockprobe.studies import PAGE, RESULTS


def write_report(
    directory: Path | str,
    *,
    tell: Callable[[str], None] = lambda said: None,
    left_out: Callable[[LeftOutSection], None] = lambda section: None,
) -> Path:
    """Write ``results.json``, ``figures/``, ``tables/``, and the page into a study directory.

    Every file is replaced in one step, ``report.html`` last. Figures of fixed names that this report has not go. No
    single section can keep the report from being written: one that cannot be made is left out and named, with its
    reason, on the page and in ``results.json``.

    Args:
        directory: The directory of a study.
        tell: Told what it is at.
        left_out: Told every section that could not be made.

    Returns:
        Where ``report.html`` is.

    Raises:
        BadFile: If the directory is not that of a study, or its records cannot be analysed together.
    """
    directory = Path(directory)
    gc.disable()  # the collector would look through all trials again and again and find little
    try:
        with threadpool_limits(ONE_THREAD):
            write_files(directory, report_files(open_study(directory), tell=tell, left_out=left_out))
    finally:
        gc.enable()
    return directory / PAGE


def write_files(directory: Path, written: Iterable[tuple[str, str | bytes | None]]) -> None:
    """Write files into a directory, each by its path and in one step; one of None goes."""
    for name, content in written:
        path = directory / name
        if content is None:
            refuse_links(path.parent)
            path.unlink(missing_ok=True)
        else:
            make_directory(path.parent)
            write_file(path, content)


def report_files(
    opened: OpenedStudy,
    *,
    tell: Callable[[str], None],
    left_out: Callable[[LeftOutSection], None] = lambda section: None,
) -> Iterator[tuple[str, str | bytes | None]]:
    """Every file of a report of these records by its path, the page last; None for one that is removed."""
    tell(f"testing {count(len(opened.trials), 'trial')}")
    with leaving_out() as failed:
        found = results_of(opened)
        tell("drawing the figures")
        page = Page(found=found, made=time_said() if found.progress.partial else "")
        page.trials = section("Trial explorer", partial(explorer_data, opened.trials, found), str)
        drawn = {
            name: section(f"Figure {name}", partial(drawn_figure, found, figure), bytes)
            for name, figure in figures_of(page.parts).items()
        }
        page.drawn = {name: image(svg) for name, svg in drawn.items() if svg}
        page.photographs = section("What agents saw", partial(embedded, opened.directory, found), dict[str, str])
        written = page.files()
        if failed:  # page and results name what is not in them
            written = replace(page, found=found.changed(sections_left_out=tuple(failed))).files()
    for one in failed:
        left_out(one)
    *numbers, last = written
    yield from numbers
    yield from ((f"figures/{name}.svg", svg or None) for name, svg in drawn.items())
    yield last


def drawn_figure(found: Results, figure: Figure) -> bytes:
    """A figure as SVG; empty if there is nothing to draw."""
    from lockprobe.report.figures.drawing import render

    made = figure.draw(found) if figure.applies(found) else None
    return b"" if made is None else render(made, "svg")


def image(svg: bytes) -> Markup:
    """A figure of Matplotlib as the attributes of an image, without what only a file needs; to .01 points."""
    small = re.sub(r"<metadata>.*?</metadata>|<!--.*?-->|<\?xml.*?\?>|<!DOCTYPE.*?>", "", svg.decode(), flags=re.DOTALL)
    wide = re.search(r'width="([\d.]+)pt"', small)
    text = re.sub(r"(?<!scale\()(\b\d+\.\d\d)\d+", r"\1", re.sub(r"\s+", " ", small)).replace('"', "'")
    source = quote(text, safe=" !$'()*+,-./:;=?@[]^_`{|}~")
    pixels = round(float(wide[1]) * 96 / 72) if wide else 0
    return own_markup(f'src="data:image/svg+xml,{source}" width="{pixels}"')


@dataclass
class Page:
    """What the template of the page reads.

    Attributes:
        found: The results.
        drawn: Figure -> the attributes of its image.
        photographs: Pictures that agents saw, by the names of their files.
        trials: The data of the trial explorer.
        made: When it was made, of a study with open trials.
    """

    found: Results
    drawn: Mapping[str, Markup] = field(default_factory=dict)
    photographs: Mapping[str, str] = field(default_factory=dict)
    trials: str = ""
    made: str = ""
    _cells: dict[Table, Sequence[Sequence[Entry]]] = field(default_factory=dict, init=False)

    @cached_property
    def parts(self) -> list[Part]:
        """Its parts."""
        return parts_of(self.found)

    def files(self) -> list[tuple[str, str | bytes | None]]:
        """The files of numbers, and the page."""
        tables = {one.name: self.cells(one) for of in all_sections() for one in of.tables}
        written = [(f"tables/{name}.csv", as_csv(table) if table else None) for name, table in tables.items()]
        return [(RESULTS, results_text(self.found)), *written, (PAGE, self.text())]

    def text(self) -> str:
        """The page, with our one script and its hash."""
        script = files("lockprobe.report").joinpath("templates/report.js").read_text(encoding="utf-8")
        digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
        return rendered("report", found=self.found, page=self, script=script, script_hash=f"sha256-{digest}")

    def cells(self, table: Table) -> Sequence[Sequence[Entry]]:
        """The rows of a table, made once."""
        if table not in self._cells:
            self._cells[table] = cells_of(table, self.found)
        return self._cells[table]

    def template(self, block: Template) -> Markup:
        """A block that has a template of its own."""
        return own_markup(rendered(block.name, found=self.found, page=self, **block.values))

    def written(self, part: Part) -> Markup:
        """The blocks of a part; a line that says so if they cannot be written."""
        missing = '<p class="off">This section could not be written; the top of the page says why.</p>'
        write = partial(rendered, "written", blocks=list(part.blocks), page=self)
        return own_markup(section(part.heading, write, lambda: missing))


def parts_of(found: Results) -> list[Part]:
    """The parts of the page, each named after its section."""
    return [
        replace(part, name=part.name or one.name, blocks=section(one.title, partial(list, part.blocks), list[Block]))
        for one in all_sections()
        for part in section(one.title, lambda one=one: list(one.show(found)), list[Part])  # type: ignore[misc]
    ]


def figures_of(parts: Iterable[Part]) -> dict[str, Figure]:
    """All figures by name: those of sections, and those that only these parts show."""
    shown = [block for part in parts for block in part.blocks if isinstance(block, Figure)]
    return {one.name: one for one in (*(figure for of in all_sections() for figure in of.figures), *shown)}


def cells_of(table: Table, found: Results) -> Sequence[Sequence[Entry]]:
    """The rows of a table; one that says so if they cannot be made."""
    return section(f"Table {table.name}", partial(table.cells, found), lambda: [["This table could not be made."]])


def results_text(found: Results) -> str:
    """The content of ``results.json``: one row a line, without what has its default."""
    text = json.JSONEncoder(ensure_ascii=False, allow_nan=False).encode
    lines = []
    for name, value in found.plain().items():
        rows = ",\n".join(f"  {text(row)}" for row in value) if isinstance(value, list) else ""
        lines.append(f' "{name}": [\n{rows}\n ]' if isinstance(value, list) else f' "{name}": {text(value)}')
    return "{\n" + ",\n".join(lines) + "\n}\n"
