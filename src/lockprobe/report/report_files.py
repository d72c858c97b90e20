"""Every file that a report writes: numbers, figures, tables, and one self-contained page.

Tables, figures and pages are made from what ``results.json`` holds and from nothing else; the trial explorer and the
pictures that agents saw come from the records. Equal records give equal files; only the page of a study with open
trials says when it was made.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Literal

from lockprobe.foundation.clock import time_said
from lockprobe.foundation.left_out import LeftOutSection, leaving_out, section
from lockprobe.report.explorer import explorer_data
from lockprobe.report.format import as_csv
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.page import Page, figures_of, image
from lockprobe.report.prose import condition_words
from lockprobe.report.questions import all_sections
from lockprobe.report.questions.seen import embedded
from lockprobe.report.results import results_of, with_left_out
from lockprobe.report.rows import Results
from lockprobe.report.rows.primary import primary_lines
from lockprobe.report.section import Figure
from lockprobe.report.study_numbers import StudyNumbers

File = tuple[str, str | bytes | None]
"""A file by its path in the directory, with its content; None for one that is removed."""

_FORMS: tuple[Literal["svg", "png"], ...] = ("svg", "png")
"""Of figures: all of them, and those that are shown on slides."""


def report_files(
    opened: OpenedStudy,
    *,
    tell: Callable[[str], None],
    left_out: Callable[[LeftOutSection], None] = lambda section: None,
) -> Iterator[File]:
    """Every file of a report, the report last.

    Args:
        opened: The study.
        tell: Told what it is at.
        left_out: Told every section that could not be made.

    Raises:
        BadFile: If its records cannot be analysed together.
    """
    if not opened.finished:
        tell("no trial has ended yet")
    tell(f"testing {len(opened.trials)} trial{'s' * (len(opened.trials) != 1)}")
    with leaving_out() as failed:
        found = results_of(StudyNumbers(opened=opened))
        tell("drawing the figures")
        page = Page(found=found, made=time_said() if found.progress.partial else "")
        page.trials = section(
            "Trial explorer", partial(_trials, opened, found), partial(explorer_data, (), found.boxes)
        )
        own = [figure for one in all_sections() for figure in one.figures]
        forms = {
            figure.name: section(f"Figure {figure.name}", partial(drawn_figure, found, figure), dict[str, bytes])
            for figure in {one.name: one for one in (*own, *figures_of(page.parts))}.values()
        }
        page.drawn = {name: image(made["svg"]) for name, made in forms.items() if made}
        page.photographs = section("What agents saw", partial(embedded, opened.directory, found), dict[str, str])
        texts, text = _texts(page), page.text()
        if failed:  # pages and results name what is not in them
            page = replace(page, found=with_left_out(found, failed))
            texts, text = _texts(page), page.text()
    for one in failed:
        left_out(one)
    yield from texts
    for name, made in forms.items():
        yield from ((f"figures/{name}.{form}", made.get(form)) for form in _FORMS)
    yield "report.html", text


def _trials(opened: OpenedStudy, found: Results) -> str:
    """The data of the trial explorer, which begins with the first effect that was detected."""
    lines = [line for line in primary_lines(found) if line.second] or primary_lines(found)
    first = sorted(lines, key=lambda line: not (line.change and line.change.detected))[:1]
    start = (first[0].agent, first[0].modality, *first[0].conditions) if first else ()
    words, budget = condition_words(found), opened.study.max_steps
    return explorer_data(opened.trials, found.boxes, budget=budget, start=start, called=words)


def drawn_figure(found: Results, figure: Figure) -> dict[str, bytes]:
    """A figure in its forms; none if there is nothing to draw."""
    from lockprobe.report.figures import render

    made = figure.draw(found) if figure.applies(found) else None
    return {} if made is None else {form: render(made, form) for form in _FORMS[: 1 + figure.slide]}


def _texts(page: Page) -> list[File]:
    """The files of numbers."""
    tables = {one.name: page.cells(one) for of in all_sections() for one in of.tables}
    written = [(f"tables/{name}.csv", as_csv(table) if table else None) for name, table in tables.items()]
    return [("results.json", results_text(page.found)), *written]


def results_text(found: Results) -> str:
    """The content of ``results.json``: one row a line, without what has its default."""
    text = json.JSONEncoder(ensure_ascii=False, allow_nan=False).encode
    lines = []
    for name, value in found.plain().items():
        if isinstance(value, list):
            rows = ",\n".join(f"  {text(row)}" for row in value)
            lines.append(f' "{name}": [\n{rows}\n ]')
        else:
            lines.append(f' "{name}": {text(value)}')
    return "{\n" + ",\n".join(lines) + "\n}\n"
