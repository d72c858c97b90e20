"""The sections of a report, in the order of the page; packages add theirs by the entry point ``lockprobe.sections``."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import replace
from functools import cache
from importlib import import_module

from lockprobe.errors import UserMistake
from lockprobe.plugins import Plugin, find_plugin, plugin_names, runs_foreign_code
from lockprobe.report.section import Part, Section
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.rows import Results, Row

__all__ = ["all_sections", "own_sections", "section_of_package"]

_OWN = (
    "overview", "findings", "study_design", "people", "leaderboard", "agents_compared", "success", "effects", "doses",
    "speed", "seen", "optimal_actions", "loops", "one_false_report", "hypothesis_tests", "misinterpretations",
    "conditions", "trials", "broken", "agents", "limits", "claims", "audit", "why", "forks",
)  # fmt: skip
"""Modules of this package, each with its ``SECTIONS``."""


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
        if twice := {*taken} & {*made.names}:
            raise ValueError(f"these names are taken: {', '.join(sorted(twice))}")

    def rows(numbers: StudyNumbers) -> Iterator[Row]:
        with plugin.guarded():
            found = [row.model_copy(update={"source": plugin.package}) for row in made.rows(numbers)]
        yield from found

    def show(found: Results) -> Iterator[Part]:
        with plugin.guarded():
            parts = [replace(part, blocks=list(part.blocks)) for part in made.show(found)]
        yield from parts

    return replace(made, rows=rows, show=show, page="report", source=plugin.package)
