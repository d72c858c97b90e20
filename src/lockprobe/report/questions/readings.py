"""What a false report is: what is inverted, what becomes of it, how often it was false, and what that changes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from markupsafe import Markup

from lockprobe.foundation.formatting import capital
from lockprobe.interventions.conditions import tells_positions
from lockprobe.report.answer import headline
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.primary import dose_lines
from lockprobe.report.prose import cause, false_reports, interval_kind, inverted
from lockprobe.report.questions.success import panel
from lockprobe.report.rows import Course, Fact, Results, Row, detected_said
from lockprobe.report.section import Block, Figure, Note, Part, Section
from lockprobe.statistics.design import READING_FACTORS

_NAME = "readings"

_BOTH_FIT = "The paper does not say which of these false reports it has; its numbers fit agents under each."
"""Of several readings (``docs/readings.md``)."""

_ONE = "Whether other false reports do the same is not tested (--readings fresh,kept)."


def _rows(numbers: OpenedStudy) -> Iterator[Row]:
    study = numbers.study
    positions = any(map(tells_positions, study.modalities))
    if not any(study.p) or not positions:
        return
    said = f"The flip rate is the probability that {inverted(study.flip, positions=positions)}."
    yield Fact(about=_NAME, name="what", text=said)


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
    if not (what := found.fact(_NAME, "what")):
        return
    answer = capital(what.removeprefix("The flip rate is the probability that "))
    rows = found.where("success_difference", of="", versus="")
    compared, several = [row for row in rows if row.axis in READING_FACTORS], len(found.readings) > 1
    others = [one for one, options in found.readings if options] * several
    effects = [headline(dose_lines(found, one), cause(one.axis)) for one in others]
    said: list[Block] = [*filter(None, [_BOTH_FIT if compared else _ONE * (not several), *effects])]
    said += [_FIGURE] * several + [detected_said(compared, "differences between readings"), _NOTE] * bool(compared)
    yield Part("What is a false report here?", answer, said, _NAME)


SECTIONS = (Section(_NAME, "What a false report is", _rows, _show, figures=(_FIGURE,)),)
