"""Every file that a report writes: numbers, figures, tables, and one self-contained page.

Tables, figures and pages are made from what ``results.json`` holds and from nothing else; the trial explorer and the
pictures that agents saw come from the records. Equal records give equal files.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from importlib import import_module
from typing import Any, Literal

from lockprobe.foundation.left_out import LeftOutSection, collecting, leaving_out, section
from lockprobe.foundation.parallel import Each
from lockprobe.report.explorer import explorer_data
from lockprobe.report.format import as_csv
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.page import figures_of, page_of, parts_of, tables_of
from lockprobe.report.questions import all_sections
from lockprobe.report.questions.seen import embedded
from lockprobe.report.results import results_of, with_left_out
from lockprobe.report.rows import Results
from lockprobe.report.rows.primary import condition_words, primary_lines
from lockprobe.report.section import Caption, Figure
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.report.svg import Image, image

File = tuple[str, str | bytes | None]
"""A file by its path in the directory, with its content; None for one that is removed."""

_FORMS: tuple[Literal["svg", "png"], ...] = ("svg", "png")
"""Of figures: all of them, and those that are shown on slides."""


@dataclass(frozen=True, slots=True)
class _Drawn:
    """A figure: its files by form, and how pages embed it."""

    files: Mapping[str, bytes]
    image: Image


@dataclass(frozen=True, slots=True)
class _Parts:
    """What files and pages are put together from.

    Attributes:
        drawn: The figures by name.
        trials: The data of the trial explorer.
        photographs: Pictures that agents saw, by the names of their files.
        texts: The files of numbers: results and tables.
    """

    drawn: Mapping[str, _Drawn]
    trials: str
    photographs: Mapping[str, str]
    texts: Sequence[File]


_Made = Callable[[Results], Any]
"""What is made of results, by this process or by another one."""

_MakeAll = Callable[[Iterable[_Made]], Iterable[Any]]
"""Makes several things of the same results, in their order."""


def report_files(
    opened: OpenedStudy,
    *,
    tell: Callable[[str], None],
    left_out: Callable[[LeftOutSection], None] = lambda section: None,
    each: Each,
) -> Iterator[File]:
    """Every file of a report, the report last.

    Args:
        opened: The study.
        tell: Told what it is at.
        left_out: Told every section that could not be made.
        each: Works on one job after the other, or on several at once.

    Raises:
        BadFile: If its records cannot be analysed together.
    """
    if not opened.finished:
        tell("no trial has ended yet")
    tell(f"testing {len(opened.trials)} trial{'s' * (len(opened.trials) != 1)}")
    with leaving_out() as failed:
        found = results_of(StudyNumbers(opened=opened))
        tell("drawing the figures")
        of = partial(_make, found)  # one value, which other processes are sent once
        parts = _parts(opened, found, partial(collecting(each), of))
        files = list(_files(found, parts))
        if failed:  # pages and results name what is not in them
            found = with_left_out(found, failed)
            files = list(_files(found, replace(parts, texts=_texts(found))))
    for one in failed:
        left_out(one)
    yield from files


def _parts(opened: OpenedStudy, found: Results, make: _MakeAll) -> _Parts:
    """All that pages are put together from; the explorer first, since it needs trials, which this process has."""
    figures = _figures(found)
    made: Iterable[_Made] = (
        lambda found: section(
            "Trial explorer",
            lambda: explorer_data(
                opened.trials,
                found.boxes,
                budget=opened.study.max_steps,
                start=_start(found),
                called=condition_words(found),
            ),
            lambda: explorer_data((), found.boxes),
        ),
        _texts,
        *figures.values(),
    )
    trials, texts, *drawn = make(made)
    return _Parts(
        drawn={name: one for name, one in zip(figures, drawn, strict=True) if one is not None},
        trials=trials,
        photographs=section("What agents saw", lambda: embedded(opened.directory, found), dict[str, str]),
        texts=texts,
    )


def _start(found: Results) -> tuple[str, ...]:
    """Agent, modality and conditions of the first trials on the page: those of the first effect that was detected."""
    lines = [line for line in primary_lines(found) if line.second] or primary_lines(found)
    for line in sorted(lines, key=lambda line: not (line.change and line.change.detected))[:1]:
        return line.agent, line.modality, *line.conditions
    return ()


def _make(found: Results, made: _Made) -> Any:
    return made(found)


def _figures(found: Results) -> dict[str, _Made]:
    """The figures that pages and sections show, by name."""
    asked: dict[str, _Made] = {}
    shown = figures_of(parts_of(found))
    for figure in (*shown, *(figure for one in all_sections() for figure in one.figures)):
        if figure.name not in asked and section(f"Figure {figure.name}", partial(figure.applies, found), bool):
            asked[figure.name] = partial(_draw, _alone(figure))
    return asked


def _alone(figure: Figure) -> Figure:
    """What is drawn of a figure, without functions that cannot be sent to another process."""
    return replace(figure, applies=_whatever, caption=Caption(""))


def _whatever(found: Results) -> bool:
    return True


def _draw(figure: Figure, found: Results) -> _Drawn | None:
    """A figure; None if there is nothing to draw, or it cannot be drawn."""

    def draw() -> _Drawn | None:
        forms = drawn_figure(found, figure)
        return None if forms is None else _Drawn(forms, image(forms["svg"]))

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


def _files(found: Results, parts: _Parts) -> Iterator[File]:
    yield from parts.texts
    for name in dict.fromkeys([*parts.drawn, *(one.name for of in all_sections() for one in of.figures)]):
        files = parts.drawn[name].files if name in parts.drawn else {}
        for form in _FORMS:
            yield f"figures/{name}.{form}", files.get(form)
    images = {name: figure.image for name, figure in parts.drawn.items()}
    yield "report.html", page_of(found, images, parts.photographs, parts.trials)


def _texts(found: Results) -> list[File]:
    """The files of numbers."""
    tables = [(f"tables/{name}.csv", as_csv(table) if table else None) for name, table in tables_of(found).items()]
    return [("results.json", results_text(found)), *tables]


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
    return json.dumps(value, ensure_ascii=False, allow_nan=False)
