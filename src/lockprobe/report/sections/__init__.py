"""The sections of a report, in the order of the page; packages add theirs by the entry point ``lockprobe.sections``."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cache
from importlib import import_module
from typing import get_args

from lockprobe.errors import UserMistake
from lockprobe.plugins import Plugin, find_plugin, plugin_names, runs_foreign_code
from lockprobe.report.section import Block, Figure, Part, Section, Table, nested
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.rows import Results, Row

__all__ = ["all_sections", "own_sections", "section_of_package"]

_OWN = (
    "overview", "findings", "study_design", "people", "leaderboard", "agents_compared", "success", "effects", "factors",
    "doses", "speed", "seen", "optimal_actions", "loops", "one_false_report", "hypothesis_tests", "misinterpretations",
    "conditions", "trials", "broken", "agents", "limits", "claims", "audit", "why", "forks",
)  # fmt: skip
"""Modules of this package, each with its ``SECTIONS``."""

_NAME = re.compile(r"[a-z0-9][a-z0-9_-]*")


@cache
def own_sections() -> tuple[Section, ...]:
    """The sections that ship with Lockprobe."""
    return tuple(one for name in _OWN for one in import_module(f"{__name__}.{name}").SECTIONS)


def all_sections() -> tuple[Section, ...]:
    """Every section of a report; those of packages only where their code may run."""
    found = list(own_sections())
    if runs_foreign_code():
        for name in plugin_names("section"):
            one = _of_package(name, {known for of in found for known in of.names})
            place = next((i for i, known in enumerate(found, 1) if known.name == one.after), len(found))
            found.insert(place, one)
    return tuple(found)


def _of_package(name: str, taken: set[str]) -> Section:
    """The section of a package; one that says why, if it cannot be used."""
    source = name
    try:
        plugin = find_plugin("section", name)
        assert plugin is not None
        source = plugin.package
        return section_of_package(plugin, taken)
    except UserMistake as mistake:
        return Section(name=name, title=f"Section {name}", rows=_raising(mistake), source=source)


def _raising(mistake: UserMistake) -> Callable[[StudyNumbers], Iterable[Row]]:
    def rows(numbers: StudyNumbers) -> Iterable[Row]:
        raise mistake

    return rows


def section_of_package(plugin: Plugin, taken: Collection[str] = ()) -> Section:
    """The section that a package adds. Its rows name the package; an error in it becomes one line that names it.

    Args:
        plugin: The package's section.
        taken: Names of other sections, of their tables and their figures.

    Raises:
        UserMistake: If it is no section, or has one of those names.
    """
    made = plugin.load()
    with plugin.guarded():
        if not isinstance(made, Section):
            raise TypeError(f"{type(made).__name__}, not a Section")
        _check_names(made.names, taken)

    def rows(numbers: StudyNumbers) -> Iterator[Row]:
        with plugin.guarded():
            found = [_checked_row(row, plugin.package) for row in made.rows(numbers)]
        yield from found

    def show(found: Results) -> Iterator[Part]:
        with plugin.guarded():
            parts = [_checked_part(part, taken) for part in made.show(found)]
        yield from parts

    return replace(made, rows=rows, show=show, page="report", source=plugin.package)


def _check_names(names: Sequence[str], taken: Collection[str]) -> None:
    """Refuse names that are no names of files and anchors, or that others have."""
    if odd := [name for name in names if not _NAME.fullmatch(name)]:
        raise ValueError(f"a name has small letters, digits, - and _ alone, unlike {', '.join(map(repr, odd))}")
    if twice := {*taken} & {*names}:
        raise ValueError(f"these names are taken: {', '.join(sorted(twice))}")


def _checked_row(row: Row, source: str) -> Row:
    """A row of a package, under its name; one that was made without checks, or that JSON cannot hold, is refused."""
    if type(row) not in get_args(Row):
        raise TypeError(f"{type(row).__name__}, not a row of lockprobe.rows")
    json.dumps(row.plain(), ensure_ascii=False, allow_nan=False).encode()
    return type(row).model_validate(row.model_dump() | {"source": source})


def _checked_part(part: Part, taken: Collection[str]) -> Part:
    if not isinstance(part, Part) or {type(part.heading), type(part.answer)} != {str}:
        raise TypeError(f"{part!r}, not a Part whose heading and answer are text")
    blocks = list(nested(checked := list(part.blocks)))
    if odd := [block for block in blocks if not isinstance(block, Block)]:
        raise TypeError(f"{type(odd[0]).__name__}, not a block of lockprobe.report.section")
    files = [block.name for block in blocks if isinstance(block, Table | Figure)]
    _check_names([*files, *filter(None, [part.name])], taken)
    return replace(part, blocks=checked)
