"""Every file that a report writes: numbers, figures, tables, and one self-contained page.

Tables, figures and pages are made from what ``results.json`` holds and from nothing else; the trial explorer and the
pictures that agents saw come from the records. Equal records give equal files; only the page of a study with open
trials says when it was made.
"""

from __future__ import annotations

import gc
import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Literal

from threadpoolctl import threadpool_limits

from lockprobe.foundation.clock import time_said
from lockprobe.foundation.left_out import LeftOutSection, leaving_out, section
from lockprobe.foundation.storage.atomic_file import make_directory, remove_file, write_file
from lockprobe.report.explorer import explorer_data
from lockprobe.report.format import as_csv
from lockprobe.report.opened import OpenedStudy, open_study
from lockprobe.report.page import Page, figures_of, image
from lockprobe.report.questions import all_sections
from lockprobe.report.questions.trials import embedded
from lockprobe.report.results import ONE_THREAD, results_of, with_left_out
from lockprobe.report.rows import Results
from lockprobe.report.section import Figure

File = tuple[str, str | bytes | None]
"""A file by its path in the directory, with its content; None for one that is removed."""

Told = Callable[[str], None]
"""Told what a report is at, since it takes some seconds."""

_FORMS: tuple[Literal["svg", "png"], ...] = ("svg", "png")
"""Of figures: all of them, and those that are shown on slides."""


def write_report(
    directory: Path | str,
    *,
    tell: Told = lambda said: None,
    left_out: Callable[[LeftOutSection], None] = lambda section: None,
) -> Path:
    """Write ``results.json``, ``figures/``, ``tables/``, and the page into a study directory.

    Every file is replaced in one step, ``report.html`` last. Figures of an earlier report that this one has not go. No
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
            for name, content in report_files(open_study(directory), tell=tell, left_out=left_out):
                path = directory / name
                if content is None:
                    remove_file(path)
                else:
                    make_directory(path.parent)
                    write_file(path, content)
    finally:
        gc.enable()
    return directory / "report.html"


def report_files(
    opened: OpenedStudy, *, tell: Told, left_out: Callable[[LeftOutSection], None] = lambda section: None
) -> Iterator[File]:
    """Every file of a report of these records, the page last; like :func:`write_report`."""
    many = len(opened.trials)
    tell(f"testing {many} trial{'s' * (many != 1)}")
    with leaving_out() as failed:
        found = results_of(opened)
        tell("drawing the figures")
        page = Page(found=found, made=time_said() if found.progress.partial else "")
        page.trials = section("Trial explorer", partial(explorer_data, opened.trials, found), str)
        figures = [*(figure for one in all_sections() for figure in one.figures), *figures_of(page.parts)]
        forms = {
            name: section(f"Figure {name}", partial(drawn_figure, found, figure), dict[str, bytes])
            for name, figure in {one.name: one for one in figures}.items()
        }
        page.drawn = {name: image(made["svg"]) for name, made in forms.items() if made}
        page.photographs = section("What agents saw", partial(embedded, opened.directory, found), dict[str, str])
        texts = _texts(page)
        if failed:  # page and results name what is not in them
            texts = _texts(replace(page, found=with_left_out(found, failed)))
    for one in failed:
        left_out(one)
    *numbers, last = texts
    yield from numbers
    for name, made in forms.items():
        yield from ((f"figures/{name}.{form}", made.get(form)) for form in _FORMS)
    yield last


def drawn_figure(found: Results, figure: Figure) -> dict[str, bytes]:
    """A figure in its forms; none if there is nothing to draw."""
    from lockprobe.report.figures.drawing import render

    made = figure.draw(found) if figure.applies(found) else None
    return {} if made is None else {form: render(made, form) for form in _FORMS[: 1 + figure.slide]}


def _texts(page: Page) -> list[File]:
    """The files of numbers, and the page."""
    tables = {one.name: page.cells(one) for of in all_sections() for one in of.tables}
    written = [(f"tables/{name}.csv", as_csv(table) if table else None) for name, table in tables.items()]
    return [("results.json", results_text(page.found)), *written, ("report.html", page.text())]


def results_text(found: Results) -> str:
    """The content of ``results.json``: one row a line, without what has its default."""
    text = json.JSONEncoder(ensure_ascii=False, allow_nan=False).encode
    lines = []
    for name, value in found.plain().items():
        rows = ",\n".join(f"  {text(row)}" for row in value) if isinstance(value, list) else ""
        lines.append(f' "{name}": [\n{rows}\n ]' if isinstance(value, list) else f' "{name}": {text(value)}')
    return "{\n" + ",\n".join(lines) + "\n}\n"
