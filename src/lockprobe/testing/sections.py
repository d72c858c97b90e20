"""The contract test of a section of the report."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory

from lockprobe.report.opened import open_study
from lockprobe.report.pages import Page, checked_cells, figures_of
from lockprobe.report.results import results_of
from lockprobe.report.rows import Results
from lockprobe.report.section import Figure, Section
from lockprobe.report.sections import checked_section, own_sections
from lockprobe.report.study_numbers import StudyNumbers, study_numbers
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.running.runner import run_study

__all__ = ["check_section"]


def check_section(section: Section) -> None:
    """Check that a section of the report fulfils its contract.

    In a study of flip rates, one of other conditions, and one without a trial: its rows are the same when they are
    asked for again, no two of its numbers have the same name, and its parts of the page, tables and figures are made
    from what ``results.json`` holds. All names that it gives are those of a package, and begin alike.

    Args:
        section: The section.

    Raises:
        AssertionError: If it breaks one of these; the message says which.
    """
    try:
        section = checked_section(section, "a package")
    except (TypeError, ValueError) as error:
        raise AssertionError(str(error)) from error
    after = [one.name for one in own_sections()]
    assert section.after in ("", *after), f"{section.name}: no section is called {section.after}; {', '.join(after)}"
    shown = 0
    with TemporaryDirectory() as scratch:
        for numbers in _studies(Path(scratch)):
            try:
                shown += _check_in(section, numbers)
            except (TypeError, ValueError) as error:
                raise AssertionError(f"{section.name}: {error}") from error
    assert shown, f"{section.name} shows nothing of any study"


def _check_in(section: Section, numbers: StudyNumbers) -> int:
    """Check its rows in a study, and what it shows of them; the number of parts."""
    rows = [*section.rows(numbers)]
    assert rows == [*section.rows(numbers)], f"{section.name}: its rows change"
    found = results_of(numbers, [replace(section, rows=lambda _: rows)])
    return _check_page(section, Results.model_validate_json(found.model_dump_json()))


def _studies(scratch: Path) -> Iterator[StudyNumbers]:
    asked = {"agent": ["human-inspired", "random"], "trials": 4, "repetitions": 1}
    for name, more in (("flips", {"p": [0, 0.4]}), ("conditions", {"p": [0], "condition": ["drop?p=0.5"]})):
        directory = scratch / name
        run_study(study("flips", **asked, **more), directory)
        opened = open_study(directory)
        yield study_numbers(opened)
        yield study_numbers(replace(opened, trials=()))


def _check_page(section: Section, found: Results) -> int:
    """Check its parts of the page and its files; the number of parts."""
    parts = [replace(part, source=section.source) for part in section.show(found)]
    page = Page(found=found)
    for part in parts:
        page.written(part)
    for table in section.tables:
        checked_cells(table, found)
    for figure in {one.name: one for one in (*section.figures, *figures_of(parts))}.values():
        _check_figure(figure, found)
    return len(parts)


def _check_figure(figure: Figure, found: Results) -> None:
    if not figure.applies(found):
        return
    module, _, function = figure.draw.partition(":")
    try:
        draw = getattr(import_module(module), function)
    except (ImportError, AttributeError, ValueError) as error:
        raise AssertionError(f"figure {figure.name}: draw names no function ({figure.draw!r}: {error})") from error
    made = draw(found, *figure.arguments)
    assert made is None or hasattr(made, "savefig"), f"figure {figure.name}: {type(made).__name__} is no figure"
