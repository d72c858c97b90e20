"""Success and false reports: how success depends on the flip rate, or on another dose, agent by agent (Fig. 4)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain
from typing import Any

from markupsafe import Markup

from lockprobe.foundation.formatting import capital, count, p_cell
from lockprobe.report.answer import headline
from lockprobe.report.format import TextTable
from lockprobe.report.prose import cause, false_reports, paper_rates, share_intervals_said
from lockprobe.report.questions.loops import loops_over_doses
from lockprobe.report.rows import Course as Shown
from lockprobe.report.rows import DoseAxis, Estimate, Results, Row
from lockprobe.report.rows.primary import CONTROL, dose_lines
from lockprobe.report.section import Block, Caption, Cells, Figure, Note, Part, Section
from lockprobe.report.study_numbers import (
    BOUNDS,
    PERMUTED,
    StudyNumbers,
    fit_rows,
    measured_row,
    of_course,
    share_rows,
    two_lines_rows,
)
from lockprobe.report.table_rows import points_cell, share_of_row
from lockprobe.statistics.conditions.axis import AGENT, FLIPS
from lockprobe.statistics.course import Course
from lockprobe.statistics.inference.over_doses import rise_and_fall, success_by_dose
from lockprobe.statistics.inference.trend import trend
from lockprobe.statistics.published import PEAK, SOLVED_AT_0, SOLVED_AT_40
from lockprobe.statistics.sequential.contrasts import E_PROCESS
from lockprobe.trial.record import PLAIN_WORDS


def _of_doses(numbers: StudyNumbers) -> Iterator[Row]:
    for axis in numbers.axes:
        for course in axis.courses:
            yield from _of_course(course)
            yield from loops_over_doses(course)


def _of_course(course: Course) -> Iterator[Row]:
    if fit := trend(course.points, "success", course.draws.success):
        for criterion, order in fit.orders.items():
            of, n = of_course(course) | {"of": f"order by {criterion}"}, len(course.points)
            yield Estimate(quantity="success_fit", **of, value=order, n=n, unit="order")
        yield from fit_rows("success_fit", fit, course)
    yield from _differences(course)
    lines = rise_and_fall(course.ended, course.broke, course.budget, agents=course.family)
    yield from two_lines_rows("success", lines, course)


def _against_lowest(course: Course, dose: float) -> dict[str, Any]:
    """The columns of a row that compares a dose with the lowest; options of agents have no condition each."""
    of = of_course(course)
    if course.axis.kind == AGENT:
        return of | {"of": f"{dose:.15g}", "doses": {f"{AGENT}.{course.axis.dose}": dose}}
    (trial, *_), (lowest, *_) = course.by_dose[dose], course.by_dose[min(course.by_dose)]
    of |= {"condition": trial.condition, "control": lowest.condition, "modality": trial.modality}
    return of | {"doses": dict(trial.doses)}


def _differences(course: Course) -> Iterator[Row]:
    """Success at every dose minus that at the lowest, both shares, and the bounds if trials broke."""
    rng = course.stream("permutation")
    tested = success_by_dose(course.ended, course.broke, rng, course.budget, agents=course.family)
    for one in tested:
        columns = _against_lowest(course, one.dose)

        def part(more: str, columns: dict[str, Any] = columns) -> dict[str, Any]:
            return columns | {"of": ", ".join(filter(None, (columns.get("of", ""), more)))}

        yield measured_row(
            "success_difference", one, **columns, n=one.second.n, unit="points",
            family=f"success by {course.axis.name}", corrected_for=len(tested) * course.family,
            test=E_PROCESS if one.course else PERMUTED,
        )  # fmt: skip
        for more, share in (("", one.second), (CONTROL, one.first)):
            yield from share_rows("success_in_pairs", share, **part(more))
        if pairs := one.pairs:
            for more, those in (("only here", pairs.only_second), (f"{CONTROL} only", pairs.only_first)):
                counted = {"value": those, "count": those, "n": pairs.n, "unit": "trials"}
                yield Estimate(quantity="success_in_pairs", **part(more) | counted)
        for more, bound in zip(BOUNDS, one.bounds or (), strict=False):
            yield Estimate(quantity="success_difference", **part(more), value=bound, unit="points")


_NOTHING = "Nothing could be compared."


def _show(found: Results) -> Iterator[Part]:
    if found.several_p:
        tested = [line for line in dose_lines(found) if line.change]
        changed = sum(line.change.detected for line in tested if line.change)
        said = f"A change was detected for {changed} of {count(len(tested), 'agent')}." if tested else _NOTHING
        yield Part("How much does success change?", said, [_FIG4, _note(found)])


def _show_doses(found: Results) -> Iterator[Part]:
    readings = [one for one, _ in found.readings] * (len(found.readings) > 1)  # readings.py has these
    axes = [(place, axis) for place, axis in enumerate(found.design.axes) if axis not in readings]
    axes = [(place, axis) for place, axis in axes if axis.key != FLIPS.name]
    for i, (place, axis) in enumerate(axes, 1):
        shown = [course for course in found.courses(axis) if course.played]
        called = capital(false_reports(axis.options)) if axis.of_flips and axis.options else _called(axis)
        lines = dose_lines(found, axis)
        alone = axis.intervention == AGENT and len(lines) == 1  # the heading names agents and option
        causes = "higher values" if alone else cause(axis.axis)
        what = headline(lines, causes, named=not alone) or _NOTHING
        pictured = f", shown as {axis.modality}" if axis.modality not in PLAIN_WORDS else ""
        said = f"Share of trials solved by {axis.name}, with the exact success of random agents."
        slide = i == 1 and not found.several_p
        drawn: dict[str, Any] = {"draw": f"{__name__}:draw", "arguments": (place,), "slide": slide}
        blocks: list[Block] = [
            Figure(f"series-{i}-success", f"Success by {axis.name}", Caption(said, _intervals(found, shown)), **drawn),
            *[Cells(_of_agents(found, axis))] * (axis.intervention == AGENT),
            _note(found),
        ]
        yield Part(f"{called}{pictured}", what, blocks, "doses" if i == 1 else f"doses-{i}")


def _called(axis: DoseAxis) -> str:
    options, rest = f" ({axis.options})" if axis.options else "", f", with {axis.rest}" if axis.rest else ""
    of = f" of {', '.join(one.agent for one in axis.players)}" * (axis.intervention == AGENT)
    return f"{axis.name.capitalize()}{of}{options}{rest}"


def _of_agents(found: Results, axis: DoseAxis) -> TextTable:
    """Success at every value of an option of agents, and its change from the lowest; no condition has these."""
    table = [["agent", axis.name, "trials", "solved", "change from the lowest", "P"]]
    for course in found.courses(axis):
        changes = {cell.dose: row for cell, row in course.changes()}
        for cell in course.played:
            row, share = changes.get(cell.dose), share_of_row(cell.get("success"))
            tested = [points_cell(row), p_cell(row.p_value) if row else ""]
            table.append([course.label, f"{cell.dose:g}", str(cell.trials), share, *tested])
    return table


def _note(found: Results) -> Note:
    tested = (
        "hold at every look: a confidence sequence and an e-process of the mean over blocks, by betting."
        if found.progress.every_look
        else "are of pairs of trials with the same luck: the larger P of the interval and of a permutation "
        "within blocks (never below 0.0005, since 2000 are drawn)."
    )
    broken = " and hold whatever became of broken trials" if any(row.value for row in found.where("broken")) else ""
    return Note(
        "Changes are points of success in the trials that were finished at both doses.",
        f"Interval and P {tested} They are corrected for all doses and agents that are judged together{broken}.",
        Markup(
            "<em>Not detected</em> does not show that there is no change. The orders of the paper's fit by its two "
            "criteria, where it turns, and the two-lines test of a rise and fall (each line must be significant) are "
            "rows <code>success_fit</code> and <code>two_lines</code> of <code>results.json</code>."
        ),
    )


def _intervals(found: Results, shown: Sequence[Shown]) -> str:
    return share_intervals_said(
        (course.agent for course in shown), every_look=bool(found.progress.every_look), boxes=len(found.boxes)
    )


def _fig4_caption(found: Results) -> Caption:
    shown = [course for course in found.courses() if course.subject]
    stars = {0.0: "23.3 % at a flip rate of 0", PEAK: "20 of 30 at 0.4, 2.85 times the success at 0"}
    drawn = " and ".join(stars[rate] for rate in paper_rates(shown))
    line = " The line is the second-order fit by least squares with its 95 % band."
    fit = line * any(course.curve("success_fit") for course in shown)
    return Caption(
        f"The paper's Fig. 4: success by flip rate.{f' Hollow stars: values in its text, {drawn}.' * bool(drawn)}",
        f"Dots are repetitions, markers their means with {_intervals(found, shown)[14:-1]}.{fit}",
        "Grey: exact success of random agents with and without immediate repeats.",
    )


def draw(found: Results, place: int | None = None) -> Any:
    """Success by dose, a panel for each agent that the study is about; by flip rate without the place of an axis."""
    from lockprobe.report.figures.compose import sheet
    from lockprobe.report.figures.frame import axis_note

    axis = None if place is None else found.design.axes[place]
    played = [course for course in found.courses(axis) if course.played and (axis or course.subject)]
    shown = played if axis is None else [one for one in played if len(one.played) > 1 and not one.blind] or played
    return sheet(shown, _panel, note=axis_note(axis) if axis else "")


def _panel(axes: Any, course: Shown) -> None:
    from lockprobe.report.figures import frame, primitives
    from lockprobe.report.figures.palette import Style, of_agent
    from lockprobe.report.figures.settings import INK

    style = of_agent(course, Style(colour=INK))
    primitives.dots(axes, [(at.dose or 0.0, success.value) for at in course.cells for success, _ in at.points], style)
    primitives.by_dose(axes, course.played, "success", style)
    if fit := course.curve("success_fit"):
        primitives.curve_with_band(axes, fit, style)
    frame.dose_axes(axes, course, "success rate")
    chance = [course.found.get("success_by_step", agent="", of=of) for of in ("uniform", "no-repeat")]
    frame.chance_band(axes, [row.value for row in chance if row and row.value is not None])
    if course.axis == FLIPS.name:
        primitives.published(axes, primitives.published_by_p(course.cells, SOLVED_AT_0, SOLVED_AT_40))
    frame.title(axes, frame.heading(course), f"{frame.counts(course.played)} per {course.name}")


_FIG4 = Figure(
    "fig4",
    "Success rate by flip rate, as in the paper",
    _fig4_caption,
    f"{__name__}:draw",
    applies=lambda found: found.several_p and any(course.played for course in found.courses()),
    slide=True,
)

SECTIONS = (
    Section(
        name="success",
        title="Success and false reports",
        rows=lambda numbers: chain.from_iterable(map(_of_course, numbers.courses)),
        show=_show,
        figures=(_FIG4,),
    ),
    Section(name="doses", title="Doses", rows=_of_doses, show=_show_doses),
)
