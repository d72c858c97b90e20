"""What a false report is: what is inverted, what becomes of it, how often it was false, and what that changes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from markupsafe import Markup

from lockprobe.foundation.formatting import capital, listed
from lockprobe.interventions.conditions import tells_positions
from lockprobe.report.answer import headline
from lockprobe.report.format import entry_text
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.primary import dose_lines
from lockprobe.report.prose import cause, condition_words, false_reports, interval_kind, inverted, who
from lockprobe.report.questions.success import panel
from lockprobe.report.rows import Course, Estimate, Fact, Results, Row, detected_said
from lockprobe.report.section import Block, Figure, Note, Part, Section
from lockprobe.statistics.arms import arms_of
from lockprobe.statistics.design import READING_FACTORS

_NAME = "readings"

_BOTH_FIT = "The paper does not say which of these false reports it has; its numbers fit agents under each."
"""Of several readings (``docs/readings.md``)."""


def _rows(numbers: OpenedStudy) -> Iterator[Row]:
    study = numbers.study
    positions = any(map(tells_positions, study.modalities))
    if not any(study.p) or not positions:
        return
    said = f"The flip rate is the probability that {inverted(study.flip, positions=positions)}."
    yield Fact(about=_NAME, name="what", text=said)
    if said := untested(numbers):
        yield Fact(about=_NAME, name="untested", text=said)


def untested(numbers: OpenedStudy) -> str:
    """That agents were played with only false reports that are soon corrected, and what the others would take."""
    study, rates, how = numbers.study, sum(rate > 0 for rate in numbers.study.p), "--readings fresh,kept"
    if any(arms_of(numbers.design.shown(modality)) for modality in numbers.design.modalities):
        rates, how = len(study.conditions), "--flip integrated"  # a study of controls has one: the other is a study
    heeding = {course.agent for course in numbers.courses if not course.blind} & {*numbers.subjects}
    alone = [
        agent
        for agent in study.run_agents
        if study.label_of(agent) in heeding
        and not any(one.doses.get("flip.keep", 0.0) > 0 for one in study.conditions_of(agent))
    ]
    if study.flip.keep or not rates or not alone:
        return ""
    more = sum(rates * study.repetitions * study.trials_of(agent) for agent in alone)
    names = listed([who(study.label_of(agent)) for agent in alone], named=3)
    return f"Not tested for {names}: whether false reports that stay do the same ({how}: {more} trials more)."


def _compared(found: Results) -> list[Estimate]:
    """Success under one reading minus success under another at the same flip rate."""
    return [row for row in found.where("success_difference", of="") if row.axis in READING_FACTORS and not row.versus]


def _answer(found: Results) -> str:
    """What it is, and the largest difference between readings that was detected."""
    what = capital(found.fact(_NAME, "what").removeprefix("The flip rate is the probability that "))
    detected = [row for row in _compared(found) if row.detected and row.agent in found.subjects]
    if not detected:
        return what
    largest, words = max(detected, key=lambda row: abs(row.value or 0.0)), condition_words(found)
    more = "more" if (largest.value or 0.0) > 0 else "fewer"
    said = f"With {words[largest.condition]}, {who(largest.agent)} solved {more} trials than with"
    return f"{what} {said} {words[largest.control]} ({entry_text(largest)} points)."


def draw(found: Results) -> Any:
    """Success by flip rate, a panel for each agent that heeds reports and was played under several readings."""
    from lockprobe.report.figures.drawing import DASHES, MARKERS, lighter, sheet, style_of

    own: dict[tuple[str, str], list[tuple[str, Any, Course]]] = {}
    for i, (axis, options) in enumerate(found.readings):
        for course in (one for one in found.courses(axis) if len(one.played) > 1 and not one.blind):
            look = style_of(course)
            look = replace(look, colour=lighter(look.colour, 0.15 * (i % 4)), marker=MARKERS[i % 4], dash=DASHES[i % 4])
            own.setdefault((course.agent, course.modality), []).append((false_reports(options), look, course))
    return sheet(sorted((one for one in own.values() if len(one) > 1), key=lambda one: not one[0][2].subject), panel)


_FIGURE = Figure(
    "readings",
    "Success by flip rate under each reading of a false report",
    lambda found: Note(
        "Share of trials solved by flip rate, a line for each reading of a false report.",
        f"Bars are {interval_kind(found)}. How many outcomes and positions are false depends on the reading and on "
        "what the agent does (false_report in results.json).",
    ),
    draw,
    applies=lambda found: len(found.readings) > 1,
)

_NOTE = Note(
    "Differences are within pairs of trials at the same flip rate.",
    Markup(
        "<i>P</i> is the larger of McNemar's exact one and that of the interval, corrected for all flip rates and for "
        "the agents (baselines apart)."
    ),
)


def _show(found: Results) -> Iterator[Part]:
    if not found.fact(_NAME, "what"):
        return
    compared, several = _compared(found), len(found.readings) > 1
    others = [one for one, options in found.readings if options] * several
    effects = [headline(dose_lines(found, one), cause(one.axis)) for one in others]
    said = [_BOTH_FIT * bool(compared), *effects, found.fact(_NAME, "untested")]
    blocks: list[Block] = [*filter(None, said), *[_FIGURE] * several]
    blocks += [detected_said(compared, "differences between readings")] if compared else []
    yield Part("What is a false report here?", _answer(found), [*blocks, *[_NOTE] * bool(compared)], _NAME)


SECTIONS = (Section(_NAME, "What a false report is", _rows, _show, figures=(_FIGURE,)),)
