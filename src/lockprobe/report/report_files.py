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
from importlib import import_module
from typing import Any, Literal

from lockprobe.foundation.clock import time_said
from lockprobe.foundation.left_out import LeftOutSection, leaving_out, section
from lockprobe.report.explorer import explorer_data
from lockprobe.report.format import as_csv
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.page import Page, figures_of
from lockprobe.report.prose import condition_words
from lockprobe.report.questions import all_sections
from lockprobe.report.questions.seen import embedded
from lockprobe.report.results import results_of, with_left_out
from lockprobe.report.rows import Results
from lockprobe.report.rows.primary import primary_lines
from lockprobe.report.section import Figure
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.report.svg import Image, image

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
        figures = _figures(page)
        page.trials, texts = _trials(opened, found), _texts(page)
        drawn = {figure.name: made for figure in figures if (made := _draw(found, figure)) is not None}
        page.drawn = {name: picture for name, (_, picture) in drawn.items()}
        page.photographs = section("What agents saw", partial(embedded, opened.directory, found), dict[str, str])
        text = page.text()
        if failed:  # pages and results name what is not in them
            page = replace(page, found=with_left_out(found, failed))
            texts, text = _texts(page), page.text()
    for one in failed:
        left_out(one)
    yield from texts
    for name in dict.fromkeys([*drawn, *(one.name for of in all_sections() for one in of.figures)]):
        forms = drawn[name][0] if name in drawn else {}
        yield from ((f"figures/{name}.{form}", forms.get(form)) for form in _FORMS)
    yield "report.html", text


def _trials(opened: OpenedStudy, found: Results) -> str:
    """The data of the trial explorer, which begins with the first effect that was detected."""

    def data() -> str:
        lines = [line for line in primary_lines(found) if line.second] or primary_lines(found)
        first = sorted(lines, key=lambda line: not (line.change and line.change.detected))[:1]
        return explorer_data(
            opened.trials,
            found.boxes,
            budget=opened.study.max_steps,
            start=(first[0].agent, first[0].modality, *first[0].conditions) if first else (),
            called=condition_words(found),
        )

    return section("Trial explorer", data, lambda: explorer_data((), found.boxes))


def _figures(page: Page) -> list[Figure]:
    """The figures that pages and sections show."""
    asked: dict[str, Figure] = {}
    for figure in (*figures_of(page.parts), *(figure for one in all_sections() for figure in one.figures)):
        if figure.name not in asked and section(f"Figure {figure.name}", partial(figure.applies, page.found), bool):
            asked[figure.name] = figure
    return [*asked.values()]


def _draw(found: Results, figure: Figure) -> tuple[dict[str, bytes], Image] | None:
    """A figure by form, and as pages embed it; None if there is nothing to draw, or it cannot be drawn."""

    def draw() -> tuple[dict[str, bytes], Image] | None:
        forms = drawn_figure(found, figure)
        return None if forms is None else (forms, image(forms["svg"]))

    return section(f"Figure {figure.name}", draw, lambda: None)


def drawn_figure(found: Results, figure: Figure) -> dict[str, bytes] | None:
    """A figure in its forms; None if there is nothing to draw."""
    from lockprobe.report.figures import render

    made = made_figure(found, figure)
    return None if made is None else {form: render(made, form) for form in _FORMS[: 1 + figure.slide]}


def made_figure(found: Results, figure: Figure) -> Any:
    """A figure of Matplotlib; None if there is nothing to draw."""
    if not figure.applies(found):
        return None
    module, _, function = figure.draw.partition(":")
    return getattr(import_module(module), function)(found, *figure.arguments)


def _texts(page: Page) -> list[File]:
    """The files of numbers."""
    tables = {one.name: page.cells(one) for of in all_sections() for one in of.tables}
    written = [(f"tables/{name}.csv", as_csv(table) if table else None) for name, table in tables.items()]
    return [("results.json", results_text(page.found)), *written]


def results_text(found: Results) -> str:
    """The content of ``results.json``: one row a line, without what has its default."""
    lines = []
    for name, value in found.plain().items():
        if isinstance(value, list):
            rows = ",\n".join(f"  {_text(row)}" for row in value)
            lines.append(f' "{name}": [\n{rows}\n ]')
        else:
            lines.append(f' "{name}": {_text(value)}')
    return "{\n" + ",\n".join(lines) + "\n}\n"


def _text(value: object) -> str:
    return _JSON.encode(value)


_JSON = json.JSONEncoder(ensure_ascii=False, allow_nan=False)
