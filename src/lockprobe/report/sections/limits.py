"""Limits: what the numbers of a report do not show."""

from __future__ import annotations

from collections.abc import Iterator

from lockprobe.report.rows import Results
from lockprobe.report.section import Part, Section, Template
from lockprobe.statistics.inference.association import LENGTH_CAVEAT

__all__ = ["SECTIONS"]


def _show(found: Results) -> Iterator[Part]:
    yield Part("Limits", "", [Template("limits", {"caveat": LENGTH_CAVEAT})])


SECTIONS = (Section(name="limits", title="Limits", show=_show),)
