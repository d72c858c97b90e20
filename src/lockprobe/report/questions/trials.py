"""Trials, step by step: one told two ways, and which is to be watched first."""

from __future__ import annotations

from collections.abc import Iterator

from lockprobe.foundation.grouping import grouped
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.rows import Fact, Results
from lockprobe.report.section import Part, Section, Template


def _rows(numbers: OpenedStudy) -> Iterator[Fact]:
    """The trial to watch first: the first of the first agent that was solved, if one was."""
    own = [one for one in numbers.trials if one.group in numbers.subjects[:1] and one.ending != "error"]
    if own:
        yield Fact(about="trials", name="first", text=min(own, key=lambda one: not one.solved).key)


def _show(found: Results) -> Iterator[Part]:
    several = any(len(own) > 1 for own in grouped(found.cells, lambda cell: (cell.agent, cell.modality)).values())
    heading = "One trial, told two ways" if several else "One trial, step by step"
    yield Part(heading, "", [Template("explorer", {"heading": heading})])


SECTIONS = (Section(name="trials", title="Trials", rows=_rows, show=_show),)
