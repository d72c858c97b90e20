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
from lockprobe.report.section import Figure, Section
from lockprobe.report.sections import own_sections
from lockprobe.report.study_numbers import StudyNumbers, study_numbers
from lockprobe.rows import Results
from lockprobe.studies.runner import run_study
from lockprobe.studies.studyfile import study

__all__ = ["check_section"]


def check_section(section: Section) -> None:
    """Check that a section of the report fulfils its contract.

    In a study of flip rates, one of other conditions, and one without a trial: its rows are the same when they are
    asked for again, no two of its numbers have the same name, none is of a quantity, section or subject that Lockprobe
    has rows of, and its parts of the page, tables and figures are made from what ``results.json`` holds. Its names are
    not those of sections, tables and figures that ship.

    Args:
        section: The section.

    Raises:
        AssertionError: If it breaks one of these; the message says which.
    """
    assert isinstance(section, Section), f"{section!r} is not a lockprobe.Section"
    after = [one.name for one in own_sections()]
    assert section.after in ("", *after), f"{section.name}: no section is called {section.after}; {', '.join(after)}"
    taken = {name for one in own_sections() for name in one.names} & {*section.names}
    assert not taken, f"{section.name}: these names are taken: {', '.join(sorted(taken))}"
    shown = 0
    with TemporaryDirectory() as scratch:
        for numbers in _studies(Path(scratch)):
            assert [*section.rows(numbers)] == [*section.rows(numbers)], f"{section.name}: its rows change"
            found = _found(section, numbers)
            shown += _check_page(section, Results.model_validate_json(found.model_dump_json()))
    assert shown, f"{section.name} shows nothing of any study"


def _found(section: Section, numbers: StudyNumbers) -> Results:
    """The results of a study with its rows."""
    rows = [row.model_copy(update={"source": "a package"}) for row in section.rows(numbers)]
    try:
        return results_of(numbers, [replace(section, rows=lambda _: rows, source="a package")])
    except ValueError as error:
        raise AssertionError(f"{section.name}: {error}") from error


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
    parts = [replace(part, blocks=list(part.blocks)) for part in section.show(found)]
    for block in (block for part in parts for block in part.blocks):
        assert hasattr(block, "block"), f"{section.name}: {block!r} is no block of lockprobe.report.section"
    strange = {one.section for one in found.findings if one.source} - {section.name}
    assert not strange, f"{section.name}: its sentences are of other sections: {', '.join(sorted(strange))}"
    page = Page(found=found)
    for part in parts:
        page.written(part)
    for table in section.tables:
        try:
            checked_cells(table, found)
        except TypeError as error:
            raise AssertionError(str(error)) from error
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
