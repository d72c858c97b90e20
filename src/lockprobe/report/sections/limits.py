"""Limits: what the numbers of a report do not show."""

from __future__ import annotations

from collections.abc import Iterator

from lockprobe.report.rows import Results
from lockprobe.report.section import Part, Section, Template
from lockprobe.statistics.inference.association import LENGTH_CAVEAT

__all__ = ["SECTIONS"]

_ANSWER = "An effect that was not detected may be there. The box and the human-inspired strategy are reconstructions."


def _show(found: Results) -> Iterator[Part]:
    errors = any(row.value for row in found.where("left_out", of="ended as error"))
    yield Part("Limits", _ANSWER, [Template("limits", {"caveat": LENGTH_CAVEAT, "errors": errors})])


SECTIONS = (Section(name="limits", title="Limits", show=_show),)
