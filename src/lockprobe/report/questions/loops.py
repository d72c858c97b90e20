"""Action loops: how often they occur beside what chance gives, and whether false reports put them off (Fig. 5)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from statistics import fmean
from typing import Any, get_args

import numpy as np
from markupsafe import Markup

from lockprobe.foundation.formatting import first_three, p_value, range_of
from lockprobe.report.format import each_or_span, entry_text
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.prose import at_lowest, chance_said, interval_kind, over_rates, paper_rates, played_subjects
from lockprobe.report.questions.success import fit_rows, turn_rows
from lockprobe.report.rows import Cell, Course, Results, Row, measured_row
from lockprobe.report.section import Figure, Note, Part, Section
from lockprobe.statistics.clustered import share_of
from lockprobe.statistics.how_soon import looping
from lockprobe.statistics.loops import cover
from lockprobe.statistics.loops.chance import Null, expected_loop_rate
from lockprobe.statistics.outcomes import ended, points
from lockprobe.statistics.proportions import ALPHA, Z
from lockprobe.statistics.published import LOOPED
from lockprobe.statistics.shape import correlation

LENGTHS = (
    "Solved trials are shorter, and short trials hold fewer loops by chance alone: a strongly negative r is expected "
    "even if loops do no harm. It cannot tell cause from trial length."
)
"""Why a correlation of loops and success is no effect."""


def _rows(numbers: OpenedStudy) -> Iterator[Row]:
    for cell in numbers.cells:
        if not (trials := ended(cell.trials)):
            continue
        own, n = cell.ended, len(trials)
        yield from cell.share("loop_rate", share_of(own.looped, own.player, own.luck, own.box))
        for one in points(own):
            yield cell.estimate("loop_rate", one.loop_rate, n=one.n, of=f"rep={one.repetition}")
        for null in get_args(Null):
            level, error = expected_loop_rate(((len(trial.steps), len(trial.joints)) for trial in trials), null)
            how: dict[str, Any] = {"note": "exact"}
            if error:
                ends = max(0.0, level - Z * error), min(1.0, level + Z * error)
                how = {"low": ends[0], "high": ends[1], "note": "simulation"}
            yield cell.estimate("loop_rate", level, of=null, n=n, **how)
        yield cell.estimate("coverage", fmean(cover(trial.actions).share for trial in trials), n=n)
    for course in numbers.every_course:  # the fit, the correlation with success, and whether first loops come later
        if not len(course.tested.ended):
            continue
        yield from fit_rows("loop_fit", "loop_rate", course)
        loops, success = (np.array([getattr(at, name) for at in course.points]) for name in ("loop_rate", "success"))
        if (r := correlation(loops, success, (course.draws["loop_rate"], course.draws["success"]))) is not None:
            test: dict[str, Any] = {"test": "Student's t", "unit": "r", "clusters": None}
            yield measured_row("loop_success", r, **course.of, of="correlation", **test)
        if hazard := looping(course.tested.ended):
            test = {"test": "log-rank", "unit": "ratio", "note": {1: "sooner", -1: "later"}.get(hazard.direction, "")}
            yield measured_row("hazard_ratio", hazard, **course.of, of="first loops", **test)
        yield from turn_rows("first loops", course)


def _said(found: Results) -> Iterator[str]:
    """Loop rates at the lowest flip rate beside chance, and whether first loops come later at higher ones."""
    lowest = [(course, course.played[0]) for course in played_subjects(found)]
    rates = [
        f"{course.label} {entry_text(cell.get('loop_rate'))}, by chance {chance_said(cell)} ({_than(cell)})"
        for course, cell in lowest
    ]
    over = [cell.value("loop_rate") or 0.0 for _, cell in lowest]
    said = each_or_span(rates, range_of(min(over, default=0.0), max(over, default=0.0)))
    yield f"Trials with a loop {at_lowest(found)}: {said}." if rates else ""
    changes = [
        f"{row.note if row.p_value < ALPHA else 'no change detected'} for {course.label} (hazard ratio "
        f"{row.value:.2f}, {p_value(row.p_value)})"
        for course, _ in lowest
        if (row := course.get("hazard_ratio", "first loops")) and row.value is not None and row.p_value is not None
    ]
    if changes:
        yield f"First loops at higher flip rates: {first_three(changes, '; ')}."


def _than(cell: Cell) -> str:
    """Whether the interval of the loop rate lies outside both levels of chance."""
    rate, chance = cell.get("loop_rate"), [cell.value("loop_rate", of) for of in get_args(Null)]
    levels = [level for level in chance if level is not None]
    if rate is None or rate.low is None or rate.high is None or not levels:
        return "not tested"
    if rate.low <= max(levels) and rate.high >= min(levels):
        return "no difference detected"
    return "more than chance" if rate.low > max(levels) else "less than chance"


def draw(found: Results, panel: Callable[[Any, Course], None]) -> Any:
    """A panel for each agent."""
    from lockprobe.report.figures.drawing import sheet

    return sheet(played_subjects(found), panel)


def by_dose(axes: Any, course: Course) -> None:
    """Fig. 5b: loop rate by flip rate, beside chance."""
    from lockprobe.report.figures import drawing as figures

    style, fit = figures.style_of(course), course.curve("loop_fit")
    figures.by_dose(axes, course.played, "loop_rate", style, linestyle="none" if fit else "-")
    if fit:
        axes.plot(fit.x, figures.numbers(fit.value), color=style.colour, linewidth=1.4)
    figures.share_axis(axes, "trials with an action loop")
    figures.dose_axis(axes, course.cells, course.name)
    places = [cell.dose or 0.0 for cell in course.played]
    chance = ([cell.value("loop_rate", of) or 0.0 for cell in course.played] for of in get_args(Null))
    axes.fill_between(places, *chance, color="#999999", alpha=0.3, linewidth=0, zorder=1, label="random actions")
    figures.published(axes, [(rate, LOOPED[rate > 0].value) for rate in paper_rates(course.cells)])
    trials = figures.counts(cell.trials for cell in course.played)
    figures.title(axes, figures.heading(course), f"{trials} per flip rate")


def against_success(axes: Any, course: Course) -> None:
    """Fig. 5a: loop rate against success."""
    from lockprobe.report.figures import drawing as figures

    style, cells = figures.style_of(course), course.cells[:1] if course.blind else course.cells
    shares = [(loops.value or 0.0, success.value or 0.0) for cell in cells for success, loops in cell.points]
    figures.dots(axes, shares, style, size=16)
    r = course.get("loop_success", "correlation")
    if r is not None:
        x, y = np.array(shares).T
        ends = np.array([x.min(), x.max()])
        axes.plot(ends, np.polyval(np.polyfit(x, y, 1), ends), color=style.colour, linewidth=1.4)
    said = f"r = {entry_text(r)}" if r else "no r of so few or equal dots"
    figures.title(axes, figures.heading(course), f"{said}; {len(shares)} dots")
    figures.share_axis(axes, "trials with an action loop", "x", grid=False)
    figures.share_axis(axes, "success rate")


def _caption(found: Results) -> Note:
    shown = played_subjects(found)
    fit = ", with the second-order fit" if any(course.curve("loop_fit") for course in shown) else ""
    cells = [cell for course in shown for cell in course.cells]
    stars = " Stars: the paper, reconstructed as 24 of 30 trials at 0 and 16 of 30 at 0.4." * bool(paper_rates(cells))
    return Note(
        f"Share of trials with an action loop by flip rate (the paper's Fig. 5b){fit}. Grey: random actions in trials "
        "of the same lengths, between uniform ones and those without immediate repeats.",
        f"Intervals are {interval_kind(found, success=False)}.{stars}",
    )


_DOTS = Note(
    "Share of trials with an action loop against success, one dot per repetition and flip rate (the paper's Fig. 5a), "
    "with the least-squares line and r.",
    LENGTHS,
)

_FIGURES = (
    Figure(
        "fig5b", "Share of trials with an action loop by flip rate", _caption, partial(draw, panel=by_dose), over_rates
    ),
    Figure("fig5a", "Loop rate against success", lambda found: _DOTS, partial(draw, panel=against_success), over_rates),
)


def _show(found: Results) -> Iterator[Part]:
    if not found.where("loop_rate"):
        return
    answer, *more = _said(found)
    definition = Markup(
        "Action loop: three or more attempts in a row that occur twice without overlap. A loop is no fault by itself: "
        "<code>round-robin</code> loops by design."
    )
    figures = _FIGURES if over_rates(found) else ()
    yield Part("Loops beyond chance?", answer, [definition, *more, *figures])


SECTIONS = (Section(name="loops", title="Action loops", rows=_rows, show=_show, figures=_FIGURES),)
