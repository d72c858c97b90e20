"""Success and false reports: how success depends on the flip rate, or on another dose, agent by agent (Fig. 4)."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

from markupsafe import Markup

from lockprobe.foundation.formatting import capital, count
from lockprobe.foundation.grouping import grouped
from lockprobe.report.answer import headline
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.primary import CONTROL, dose_lines
from lockprobe.report.prose import cause, false_reports, interval_kind, over_rates, paper_rates
from lockprobe.report.rows import BOUNDS, Curve, DoseAxis, Estimate, Results, Row, measured_row, share_rows
from lockprobe.report.rows import Course as Shown
from lockprobe.report.section import BY_BETTING, Figure, Note, Part, Section
from lockprobe.statistics.course import Course
from lockprobe.statistics.design import FLIPS
from lockprobe.statistics.differences import any_difference
from lockprobe.statistics.published import PEAK, SOLVED
from lockprobe.statistics.shape import Quantity, Turning, trend, two_lines
from lockprobe.trial.record import PLAIN_WORDS

_NOTHING = "Nothing could be compared."

_ALIKE = "Agents that play alike whatever they are told have no panel beside others."


def fit_rows(quantity: str, of: Quantity, course: Course) -> Iterator[Row]:
    """The paper's second-order least-squares fit over repetitions."""
    if fit := trend(course.points, of, course.draws[of]):
        yield Curve(quantity=quantity, **course.of, n=len(course.points), **fit)


def turn_rows(of: Turning, course: Course, agents: int = 1) -> Iterator[Row]:
    """Where two lines meet, and the shape that they show."""
    found = two_lines(course.tested, of, agents=agents)
    if found.value is not None:
        shape = {"unit": "dose", "note": found.direction or ""}
        yield measured_row("two_lines", found, **course.of, of=of, test="two lines", **shape)


def _rows(numbers: OpenedStudy) -> Iterator[Row]:
    for course in numbers.every_course:
        yield from fit_rows("success_fit", "success", course)
        tested = any_difference(course.tested, course.stream("permutation"), agents=course.family)
        for one in tested:  # the difference, both shares, and the bounds if trials broke
            columns = course.of | course.by_dose[one.dose].of | {"control": course.cells[0].condition}
            yield measured_row(
                "success_difference", one, **columns, n=one.second.n, unit="points",
                family=f"success by {course.axis.name}", corrected_for=len(tested) * course.family,
                test=one.test,
            )  # fmt: skip
            for part, share in (("", one.second), (CONTROL, one.first)):
                yield from share_rows("success_in_pairs", share, **columns, of=part)
            for part, bound in zip(BOUNDS, one.bounds or (), strict=False):
                yield Estimate(quantity="success_difference", **columns, of=part, value=bound, unit="points")
        if course.order is None:
            yield from turn_rows("success", course, course.family)


def _show(found: Results) -> Iterator[Part]:
    if found.several_p:
        tested = grouped([line for line in dose_lines(found) if line.change], lambda line: line.baseline)
        counts = [
            f"{sum(bool(line.change and line.change.detected) for line in lines)} of {count(len(lines), 'agent')}"
            f"{' for comparison' * baseline}"
            for baseline, lines in sorted(tested.items())
        ]
        said = f"A change was detected for {' and for '.join(counts)}." if counts else _NOTHING
        yield Part("How much does success change?", said, [_FIG4, _note(found)])
    axes = [one for one in found.design.axes if one.axis.key != FLIPS.name]
    for i, axis in enumerate(axes, 1):
        dose = axis.axis
        options, rest = f" ({dose.options})" if dose.options else "", f", with {dose.rest}" if dose.rest else ""
        called = f"{dose.name.capitalize()}{options}{rest}"
        called = capital(false_reports(dose.options)) if dose.of_flips and dose.options else called
        pictured = f", shown as {dose.modality}" if dose.modality not in PLAIN_WORDS else ""
        what = headline(dose_lines(found, axis), cause(dose)) or _NOTHING
        caption, drawn = partial(_dose_caption, dose=dose.name), partial(draw, axis=axis)
        figure = Figure(f"series-{i}-success", f"Success by {dose.name}", caption, drawn)
        yield Part(f"{called}{pictured}", what, [figure, _note(found)], "doses" if i == 1 else f"doses-{i}")


def _note(found: Results) -> Note:
    tested = (
        BY_BETTING
        if found.progress.every_look
        else "are of pairs of trials with the same luck: the larger P of the interval and of a permutation "
        "within blocks (never below 0.0005, since 2000 are drawn)."
    )
    broken = " and hold whatever became of broken trials" if any(row.value for row in found.where("broken")) else ""
    return Note(
        "Changes are points of success in the trials that were finished at both doses.",
        f"Interval and P {tested} They are corrected for all doses and agents that are judged together{broken}.",
        Markup(
            "<em>Not detected</em> does not show that there is no change. The two-lines test of a rise and fall (each "
            "line must be significant) is the row <code>two_lines</code> of <code>results.json</code>."
        ),
    )


def _dose_caption(found: Results, dose: str) -> Note:
    said = f"Share of trials solved by {dose}, with the chance level (choices at random, exact). {_ALIKE}"
    return Note(said, f"Intervals are {interval_kind(found)}.")


def _caption(found: Results) -> Note:
    shown = [course for course in found.courses() if course.subject]
    stars = {0.0: "23.3 % at a flip rate of 0", PEAK: "20 of 30 at 0.4, 2.85 times the success at 0"}
    drawn = " and ".join(stars[rate] for rate in paper_rates(cell for course in shown for cell in course.cells))
    line = " The line is the second-order fit by least squares with its 95 % band."
    fit = line * any(course.curve("success_fit") for course in shown)
    return Note(
        f"The paper's Fig. 4: success by flip rate.{f' Hollow stars: values in its text, {drawn}.' * bool(drawn)}",
        f"Dots are repetitions, markers their means with {interval_kind(found)}.{fit}",
        f"Grey: the chance level, choices at random with and without immediate repeats, exact. {_ALIKE}",
    )


def draw(found: Results, axis: DoseAxis | None = None) -> Any:
    """Success by dose, a panel for each agent that does not play alike at all; by flip rate without an axis."""
    from lockprobe.report.figures.drawing import sheet

    played = [course for course in found.courses(axis) if course.played and (axis or course.subject)]
    heed = [one for one in played if len(one.played) > 1 and not one.blind]
    shown = sorted(heed or played, key=lambda one: not one.subject)
    note = f"{capital(false_reports(axis.axis.options))}." if axis and axis.axis.of_flips and axis.axis.options else ""
    return sheet(shown, _panel, note=note)


def _panel(axes: Any, course: Shown) -> None:
    """The success of one agent by dose."""
    from lockprobe.report.figures import drawing as figures

    style, cells = figures.style_of(course), course.played
    figures.by_dose(axes, cells, "success", style)
    repetitions = [(at.dose or 0.0, success.value) for at in course.cells for success, _ in at.points]
    figures.dots(axes, repetitions, style)
    if fit := course.curve("success_fit"):
        axes.plot(fit.x, figures.numbers(fit.value), **{**style.line, "marker": "", "zorder": 3})
        if fit.low:
            ends = figures.numbers(fit.low), figures.numbers(fit.high)
            axes.fill_between(fit.x, *ends, color=style.colour, alpha=0.15, linewidth=0, zorder=1)
    figures.share_axis(axes, "success rate")
    figures.dose_axis(axes, cells, course.name)
    if levels := [curve.value[-1] or 0.0 for curve in course.found.random_play]:
        look: dict[str, Any] = {"color": figures.FAINT, "alpha": 0.18, "linewidth": 0, "zorder": 0}
        axes.axhspan(min(levels), max(levels), label="chance level", **look)
    if cells[0].p is not None and course.subject:
        figures.published(axes, [(rate, SOLVED[rate > 0].value) for rate in paper_rates(cells)])
    trials = figures.counts(cell.trials for cell in cells)
    figures.title(axes, figures.heading(course), f"{trials} per {course.name}")


_FIG4 = Figure("fig4", "Success rate by flip rate, as in the paper", _caption, draw, applies=over_rates)

SECTIONS = (Section("success", "Success and false reports", _rows, _show, figures=(_FIG4,)),)
