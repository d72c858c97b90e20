"""Trials, step by step: one told two ways, and which is to be watched first."""

from __future__ import annotations

from collections.abc import Iterator

from lockprobe.report.rows import Fact, Results
from lockprobe.report.section import Part, Section, Template
from lockprobe.report.study_numbers import StudyNumbers


def _rows(numbers: StudyNumbers) -> Iterator[Fact]:
    """The trial to watch first: solved if one is, under the flip rate that stands out if one does."""
    subjects = [one.agent for one in numbers.flips.subjects] or [*(numbers.others.subjects if numbers.others else ())]
    contrast = next((one.contrast for one in numbers.flips.subjects[:1]), None)
    rate = contrast.other.dose if contrast else None
    own = [one for one in numbers.opened.trials if one.group in subjects[:1] and one.ending != "error"]
    if own:
        first = min(own, key=lambda one: (not one.solved, rate not in (None, one.p)))
        yield Fact(about="trials", name="first", text=first.key)


def _show(found: Results) -> Iterator[Part]:
    several = len(found.design.conditions) > 1
    heading = "One trial, told two ways" if several else "One trial, step by step"
    yield Part(heading, "", [Template("explorer", {"heading": heading})])


SECTIONS = (Section(name="trials", title="Trials", rows=_rows, show=_show),)
