"""What agents saw: pictures from one trial of each modality."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count, takewhile
from typing import Any

from lockprobe.report.rows import Fact, Results
from lockprobe.report.sample_pictures import ABOUT, KINDS, seen_facts
from lockprobe.report.section import Part, Picture, Section, Template
from lockprobe.report.study_numbers import StudyNumbers


def _rows(numbers: StudyNumbers) -> Iterator[Fact]:
    yield from seen_facts(numbers.opened.trials)


def _show(found: Results) -> Iterator[Part]:
    shown = list(_modalities(found))
    if shown:
        yield Part("What agents saw", "Pictures from one trial of each modality.", [Template("seen", {"shown": shown})])


def _modalities(found: Results) -> Iterator[dict[str, Any]]:
    for fact in found.facts:
        if fact.about.startswith(ABOUT) and fact.name == "trial":
            moments = takewhile(bool, (found.facts_about(f"{fact.about} {number}") for number in count(1)))
            yield {
                "modality": fact.about.removeprefix(ABOUT),
                "key": fact.text,
                "pictures": [_picture(moment) for moment in moments],
            }


def _picture(moment: dict[str, str]) -> Picture:
    files = [moment[kind] for kind in KINDS if kind in moment]
    when = moment["when"]
    return Picture(files, alt=f"The box {when}", caption=f"{when.capitalize()}. Told: “{moment['told']}”")


SECTIONS = (Section(name="seen", title="What agents saw", rows=_rows, show=_show),)
