"""The sections of a report, in the order of the page; packages add theirs by the entry point ``lockprobe.sections``."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from functools import cache
from importlib import import_module
from typing import get_args

from lockprobe.foundation.errors import UserMistake
from lockprobe.foundation.plugins import Plugin, find_plugin, plugin_names, runs_foreign_code
from lockprobe.report.rows import MEASURES, Exhibit, Fact, Finding, Results, Row
from lockprobe.report.section import Block, Figure, Part, Section, Table, nested
from lockprobe.report.study_numbers import StudyNumbers

__all__ = ["all_sections", "checked_section", "own_sections", "section_of_package"]

_OWN = (
    "first_screen", "trials", "findings", "people", "bridge", "factorial", "stopping", "success", "readings", "effects",
    "factors", "doses", "hypothesis_tests", "loops", "one_false_report", "leaderboard", "agents_compared",
    "agents_by_condition", "speed", "optimal_actions", "misinterpretations", "seen", "robot", "rules", "conditions",
    "study_design", "agents", "broken", "limits", "claims", "audit", "why", "forks",
)  # fmt: skip
"""Modules of this package, each with its ``SECTIONS``: the answer and one trial; whether it is more than chance, and
whether it acts through loops; agents beside each other; all numbers; the study itself."""

_NAME = re.compile(r"[a-z0-9][a-z0-9_-]*(\.[a-z0-9_-]+)+")
"""A name that a package gives. Names of Lockprobe have no point, so that no package has one of them in any study."""


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
        UserMistake: If it is no section, or its names are taken or not those of a package.
    """
    made = plugin.load()
    with plugin.guarded():
        return checked_section(made, plugin.package, taken, plugin.guarded)


def checked_section(
    made: object,
    source: str,
    taken: Collection[str] = (),
    guarded: Callable[[], AbstractContextManager[None]] = nullcontext,
) -> Section:
    """A section of a package, which checks its rows and parts when it makes them.

    Args:
        made: What should be a section.
        source: The package.
        taken: Names of other sections, of their tables and their figures.
        guarded: Turns an error in it into one line.

    Raises:
        TypeError: If it is no section, or what it makes is no row, part or block.
        ValueError: If its names are taken or not those of a package.
    """
    if not isinstance(made, Section):
        raise TypeError(f"{type(made).__name__}, not a Section")
    of, own = made, f"{made.name.partition('.')[0]}."
    _check_names(of.names, own, taken)

    def rows(numbers: StudyNumbers) -> Iterator[Row]:
        with guarded():
            found = [_checked_row(row, source, of.name, own) for row in of.rows(numbers)]
        yield from found

    def show(found: Results) -> Iterator[Part]:
        with guarded():
            parts = [_checked_part(part, own, taken) for part in of.show(found)]
        yield from parts

    return replace(of, rows=rows, show=show, page="report", source=source)


def _check_names(names: Sequence[str], own: str, taken: Collection[str]) -> None:
    """Refuse names that are no names of files and anchors, or that others have."""
    if odd := [name for name in names if not _NAME.fullmatch(name)]:
        raise ValueError(f"names of packages are like latecomer.silence, unlike {', '.join(map(repr, odd))}")
    if other := [name for name in names if not name.startswith(own) or own == f"{MEASURES}."]:
        raise ValueError(f"names of a section begin alike, and not with {MEASURES}., unlike {', '.join(other)}")
    if twice := {*taken} & {*names}:
        raise ValueError(f"these names are taken: {', '.join(sorted(twice))}")


def _checked_row(row: Row, source: str, name: str, own: str) -> Row:
    """A row of a package, under its name; one that was made without checks, or that JSON cannot hold, is refused."""
    if type(row) not in get_args(Row):
        raise TypeError(f"{type(row).__name__}, not a row of lockprobe.report.rows")
    json.dumps(row.plain(), ensure_ascii=False, allow_nan=False).encode()
    if isinstance(row, Finding | Exhibit):
        if row.section != name:
            raise ValueError(f"its rows are of the section {name}, not of {row.section!r}")
    elif not (called := row.about if isinstance(row, Fact) else row.quantity).startswith(own):
        raise ValueError(f"its quantities and facts begin with {own}, unlike {called!r}")
    return type(row).model_validate(row.model_dump() | {"source": source})


def _checked_part(part: Part, own: str, taken: Collection[str]) -> Part:
    if not isinstance(part, Part) or {type(part.heading), type(part.answer)} != {str}:
        raise TypeError(f"{part!r}, not a Part whose heading and answer are text")
    blocks = list(nested(checked := list(part.blocks)))
    if odd := [block for block in blocks if not isinstance(block, Block)]:
        raise TypeError(f"{type(odd[0]).__name__}, not a block of lockprobe.report.section")
    files = [block.name for block in blocks if isinstance(block, Table | Figure)]
    _check_names([*files, *filter(None, [part.name])], own, taken)
    return replace(part, blocks=checked)
