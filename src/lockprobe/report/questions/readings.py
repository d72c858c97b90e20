"""What a false report is: what is inverted, what becomes of it, how often it was false, and what that changes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from markupsafe import Markup

from lockprobe.foundation.formatting import capital, listed, percent
from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.spec import Spec
from lockprobe.interventions.conditions import tells_positions
from lockprobe.report.answer import headline
from lockprobe.report.prose import (
    BOTH_FIT,
    Subject,
    cause,
    condition_words,
    false_reports,
    interval_kind,
    inverted,
    reading_name,
)
from lockprobe.report.questions.conditions import cells_of, compared_rows, compared_table
from lockprobe.report.rows import Course, Estimate, Finding, Results, Row
from lockprobe.report.rows.primary import dose_lines
from lockprobe.report.section import Block, Caption, Figure, Note, Part, Section, Table, Text
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.report.table_rows import points_cell
from lockprobe.statistics.conditions.factors import NO_FEEDBACK, READING_FACTORS
from lockprobe.statistics.contrast import against_first
from lockprobe.statistics.published import SOLVED_AT_0, SOLVED_AT_40
from lockprobe.statistics.why.arms import arms_of

_NAME = "readings"


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    study, design = numbers.study, numbers.design
    positions = any(map(tells_positions, study.modalities))
    if not any(study.p) or not positions:
        return
    said = f"The flip rate is the probability that {inverted(study.flip, positions=positions)}."
    yield Finding(section=_NAME, kind="what", text=said)
    if not study.of_flips:
        yield from compared_rows(against_first(cells_of(numbers), design.no_feedback, design), numbers)
    if said := untested(numbers):
        yield Finding(section=_NAME, kind="untested", text=said)


def untested(numbers: StudyNumbers) -> str:
    """That agents were played with only false reports that are soon corrected, and what the others would take."""
    study, rates, how = numbers.study, sum(rate > 0 for rate in numbers.study.p), "--readings fresh,kept"
    if any(arms_of(numbers.design.shown(modality)) for modality in numbers.design.modalities):
        rates, how = len(study.conditions), "--flip integrated"  # a study of controls has one: the other is a study
    if study.flip.keep or not rates or not any(map(tells_positions, study.modalities)):
        return ""
    subjects = [course for course in numbers.courses if not course.baseline] or numbers.courses
    heeding = {course.agent for course in subjects if not course.blind}
    asked = [agent for agent in study.run_agents if study.label_of(agent) in heeding]
    alone = [a for a in asked if not any(one.doses.get("flip.keep", 0.0) > 0 for one in study.conditions_of(a))]
    if not alone:
        return ""
    more = sum(rates * study.repetitions * study.trials_of(agent) for agent in alone)
    names = listed([Subject.of(study.label_of(agent)).name for agent in alone], named=3)
    return f"Not tested for {names}: whether false reports that stay do the same ({how}: {more} trials more)."


def _compared(found: Results) -> list[Estimate]:
    """Success under one reading minus success under another at the same flip rate."""
    return [row for row in found.where("success_difference", of="") if row.axis in READING_FACTORS and not row.versus]


def _against_none(found: Results) -> list[Estimate]:
    """Success with false reports minus success without any report."""
    return found.where("success_difference", of="", axis=NO_FEEDBACK)


def _against_none_said(found: Results) -> Iterator[str]:
    """Whether false reports are worse than none, for each agent that the study is about."""
    words = condition_words(found)
    for agent, rows in grouped(_against_none(found), lambda row: row.agent).items():
        kinds: dict[str, list[str]] = {}
        for row in sorted(rows, key=lambda row: (not row.detected, -(row.value or 0.0))):
            more = "more with" if (row.value or 0.0) > 0 else "fewer with"
            said = f"{words[row.condition]} ({points_cell(row)} points)" if row.detected else words[row.condition]
            kinds.setdefault(more if row.detected else "no difference detected with", []).append(said)
        if agent in found.subjects:
            said = "; ".join(f"{what} {listed(those)}" for what, those in kinds.items())
            yield f"Trials that {Subject.of(agent).name} solved, against no feedback at all: {said}."


def _answer(found: Results) -> str:
    """What it is, and the largest difference between readings that was detected."""
    what = capital(" ".join(found.said(_NAME, "what")).removeprefix("The flip rate is the probability that "))
    detected = [row for row in _compared(found) if row.detected and row.agent in found.subjects]
    if not detected:
        return what
    largest = max(detected, key=lambda row: abs(row.value or 0.0))
    rate = next(one.doses.get("flip.p", 0.0) for one in found.design.conditions if one.name == largest.condition)
    kept, fresh = (_words(found, name) for name in (largest.condition, largest.control))
    fresh += " that are corrected" * (kept == f"{fresh} that stay")
    more = "more" if (largest.value or 0.0) > 0 else "fewer"
    said = f"At a flip rate of {rate:g} {Subject.of(largest.agent).name} solved {more} trials with {kept} than with "
    return f"{what} {said}{fresh} ({points_cell(largest)} points)."


def _words(found: Results, condition: str) -> str:
    """The false reports of a condition, or its name if it is more than a flip."""
    specs = next((one.specs for one in found.design.conditions if one.name == condition), ())
    acts = [Spec.parse(spec, "condition") for spec in specs]
    if [one.kind for one in acts] != ["flip"]:
        return condition
    return false_reports("&".join(f"{name}={value}" for name, value in acts[0].options.items() if name != "p"))


_TABLE = Table("readings", lambda found: compared_table(found, _compared(found)), numeric_from=3, drawn=_compared)


_SHARES = {"outcomes": ("false_report", "steps"), "positions": ("false_report", "positions")}
"""What the strip below success holds: false outcomes of all steps, and reports with a false position."""

_BLOCK = len(_SHARES) + 1.4
"""Rows of a reading in the strip: its name, its shares and what stands between it and the next."""

_Panel = Sequence[tuple[str, Any, Course]]
"""An agent under several readings: what each is, its style, and the agent's course."""


def draw(found: Results) -> Any:
    """A panel for each agent that heeds reports and was played under several readings.

    The shares of a reading stand below its line and its name, so the figure needs no legend of readings.
    """
    from lockprobe.report.figures.compose import sheet
    from lockprobe.report.figures.palette import Dash, Marker, Style, of_agent
    from lockprobe.report.figures.settings import INK

    dashes: list[Dash] = ["-", (0, (5, 1.5)), (0, (4, 1.2, 1, 1.2)), (0, (1, 1.2))]
    markers: list[Marker] = ["o", "s", "^", "D"]
    own: dict[tuple[str, str], list[tuple[str, Any, Course]]] = {}
    for i, (axis, options) in enumerate(found.readings):
        style = Style(colour=INK, marker=markers[i % 4], dash=dashes[i % 4])
        for course in found.courses(axis):
            if len(course.played) > 1 and not course.blind:
                look = of_agent(course, style, 0.15 * (i % 4))
                own.setdefault((course.agent, course.modality), []).append((reading_name(options), look, course))
    panels = sorted((one for one in own.values() if len(one) > 1), key=lambda one: not one[0][2].subject)
    rows = _BLOCK * max(map(len, panels), default=0)
    return sheet(panels, _success, _strip, heights=(1.5, 0.14 * rows))


def _success(axes: Any, panel: _Panel) -> None:
    from lockprobe.report.figures.frame import agent_label, counts, p_axis, share_axis, title
    from lockprobe.report.figures.primitives import by_dose, published, published_by_p

    first = panel[0][2]
    for _, style, course in panel:
        by_dose(axes, course.played, "success", style, linestyle=style.dash)
    cells = [cell for _, _, course in panel for cell in course.played]
    if first.subject:
        published(axes, published_by_p(cells, SOLVED_AT_0, SOLVED_AT_40))
    share_axis(axes, "success rate")
    p_axis(axes, cells)
    kind = interval_kind(first.found.progress.every_look).partition(",")[0]
    title(axes, agent_label(first), f"{counts(first.played)} per flip rate; 95 % {kind}")


def _strip(axes: Any, panel: _Panel) -> None:
    """The shares as numbers below the flip rates, those of each reading below its name and its line."""
    from lockprobe.report.figures.frame import axis, p_axis
    from lockprobe.report.figures.settings import INK

    across, names = axes.get_yaxis_transform(), {}
    for i, (words, style, course) in enumerate(panel):
        top = i * _BLOCK
        axes.plot([-0.26, -0.17, -0.08], [top] * 3, markevery=[1], transform=across, clip_on=False, **style.line)
        axes.text(-0.05, top, words, transform=across, color=INK, ha="left", va="center")
        for below, (name, (quantity, of)) in enumerate(_SHARES.items(), start=1):
            names[top + below] = name
            for cell in course.played:
                if (share := cell.value(quantity, of)) is not None:
                    axes.text(cell.dose or 0.0, top + below, percent(share), color=INK, ha="center", va="center")
    axes.set_ylim(len(panel) * _BLOCK - 0.9, -0.5)
    p_axis(axes, [cell for _, _, course in panel for cell in course.played], label="share of reports that were false")
    axis(axes, "y", [*names], [*names.values()], bare=True)


_FIGURE = Figure(
    "readings",
    "Success by flip rate under each reading of a false report, with the share of reports that were false",
    lambda found: Caption(
        "Share of trials solved by flip rate, a line for each reading of a false report. Below: share of outcomes that "
        "were reported falsely, and of reports that showed a joint in a false position.",
        f"Bars are 95 % {interval_kind(found.progress.every_look)}. How many outcomes and positions are false depends "
        "on the reading and on what the agent does.",
    ),
    draw=f"{__name__}:draw",
)

_NOTE = Note(
    "Differences are within pairs of trials at the same flip rate. A positive difference from no feedback: false "
    "reports are better than none. Strategies that ship learn from reports alone what they have tried: without any, "
    "round-robin and human-inspired repeat one joint.",
    Markup(
        "<i>P</i> is the larger of McNemar's exact one and that of the interval, corrected for all flip rates and for "
        "the agents (baselines apart); the contrasts with no feedback are a family of their own."
    ),
)


def _show(found: Results) -> Iterator[Part]:
    what, compared = found.said(_NAME, "what"), bool(_compared(found))
    if what:
        others = [one for one, options in found.readings if options] * (len(found.readings) > 1)
        effects = [headline(dose_lines(found, one), cause(one.axis)) for one in others]
        said = [*[BOTH_FIT] * compared, *effects, *found.said(_NAME, "untested"), *_against_none_said(found)]
        blocks: list[Block] = [Text(one) for one in said if one]
        blocks += (
            [_FIGURE] * (len(found.readings) > 1)
            + [_TABLE] * compared
            + [_NOTE] * (compared or bool(_against_none(found)))
        )
        yield Part("What is a false report here?", _answer(found), blocks, _NAME)


SECTIONS = (
    Section(name=_NAME, title="What a false report is", rows=_rows, show=_show, tables=(_TABLE,), figures=(_FIGURE,)),
)
