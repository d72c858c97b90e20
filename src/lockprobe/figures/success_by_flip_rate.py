"""Success by flip rate: the paper's Fig. 4, and its companion with intervals, chance and the best flip rates."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lockprobe.analysis.published import SOLVED_AT_0, SOLVED_AT_40
from lockprobe.figures.compose import sheet
from lockprobe.figures.frame import (
    EXACT,
    FAINT,
    INK,
    agent_label,
    blank,
    counts,
    heading,
    label_right,
    p_axis,
    share_axis,
    title,
)
from lockprobe.figures.palette import SUBJECTS, Style, shifts, styles
from lockprobe.figures.primitives import bars, dots, key, means, numbers, published, published_by_p, second_order_fit
from lockprobe.figures.settings import own_settings
from lockprobe.formatting import p_value, percent
from lockprobe.rows import Cell, Course, Estimate, Results

__all__ = ["draw_success_by_dose", "draw_success_by_p", "fig4", "fig4_corrected", "published_success"]


@own_settings()
def fig4(found: Results) -> Figure | None:
    """Success by flip rate, as in the paper; None without an ended trial or with a single flip rate."""
    courses = _shown(found)
    return sheet([courses], draw_success_by_p) if courses else None


@own_settings()
def fig4_corrected(found: Results) -> Figure | None:
    """The same with intervals and chance, a panel for each agent that the study is about."""
    courses = [course for course in _shown(found) if course.subject]
    return sheet(courses, draw_success_by_dose) if courses else None


def _shown(found: Results) -> list[Course]:
    courses = found.courses()
    return courses if found.several_p and any(course.played for course in courses) else []


def draw_success_by_p(axes: Axes, courses: Sequence[Course]) -> None:
    """Success over flip probability with the second-order fit (Fig. 4).

    Dots are repetitions, markers the means. References, which the paper has not, are grey, without dots and fit.
    """
    if not any(course.played for course in courses):
        return blank(axes, "no trial has ended")
    cells, moved, said = [cell for course in courses for cell in course.cells], shifts(courses), [""]
    for course, style in styles(courses):
        shift = moved[course.agent, course.modality]
        if style.lead:
            dots(axes, course, style, shift)
            said.append(second_order_fit(axes, course.curve("success_fit"), style))
        x, shares = _shares(course)
        means(axes, [p + shift for p in x], shares, style, line=not (style.lead and said[-1]))
        if shares:
            key(axes, style, heading(course).replace(", ", ",\n") if style.lead else agent_label(course))
    published(axes, published_success(cells))
    share_axis(axes, "success rate")
    p_axis(axes, cells, max(map(abs, moved.values()), default=0.0))
    return title(axes, f"{counts(cells)} per flip rate; dots: repetitions; markers: means", max(said, key=len))


def _shares(course: Course) -> tuple[list[float], list[Estimate]]:
    """The doses that have trials, and the share solved at each."""
    found = [(cell.dose or 0.0, row) for cell in course.played if (row := cell.get("success"))]
    return [dose for dose, _ in found], [row for _, row in found]


def published_success(cells: Sequence[Cell]) -> list[tuple[float, float]]:
    """Flip rates for which the paper's text gives the share solved, with that share, as far as the study has them."""
    return published_by_p(cells, SOLVED_AT_0, SOLVED_AT_40)


def draw_success_by_dose(axes: Axes, course: Course) -> None:
    """Fig. 4 by counts: Wilson's intervals, a binomial model of the order that AICc prefers, chance, and the peak.

    Triangles under the shares stand at the doses that may be the best (95 % set); the diamond is the highest share less
    what it owes to having been chosen.
    """
    x, shares = _shares(course)
    if not shares:
        return blank(axes, f"{agent_label(course)}: no trial has ended")
    style = Style(colour=SUBJECTS[0], marker="o", dash="-", lead=True)
    bars(axes, x, shares, style, label="share solved with 95 % Wilson interval")
    several = len(course.where("best_dose_probability")) > 1
    curve, order = course.curve("success_model") if several else None, course.value("success_model_order", "AICc")
    if curve is not None:
        axes.plot(
            curve.x,
            numbers(curve.value),
            color=style.colour,
            linewidth=1.4,
            zorder=3,
            label="binomial model with 95 % band",
        )
        low, high = numbers(curve.low), numbers(curve.high)
        axes.fill_between(curve.x, low, high, color=style.colour, alpha=0.14, linewidth=0, zorder=1)
    share_axis(axes, "success rate")
    p_axis(axes, course.cells, name=course.name)
    if several:
        _peak(axes, course)
    levels = {
        "random": course.value("success_chance", "uniform"),
        "no-repeat": course.value("success_chance", "no-repeat"),
    }
    known = {name: level for name, level in levels.items() if level is not None}
    for name, level in known.items():
        axes.axhline(level, color=FAINT, linewidth=0.9, linestyle=EXACT[name], zorder=2)
    label_right(axes, [(level, f"{name}\n{percent(level)}", FAINT) for name, level in known.items()], gap=0.2)
    return title(
        axes,
        heading(course),
        f"{counts(course.played)} per {course.name}" + (f"; model of order {order:g} (AICc)" if curve else ""),
        _rises_and_falls(course) if several else "",
    )


def _rises_and_falls(course: Course) -> str:
    """Whether success rises and then falls, by the test that is concluded from."""
    test = course.get("test", "shape")
    if test is None or test.p_value is None:
        return f"rise and fall: not tested, needs three {course.name}s"
    return f"rise and fall, two-lines test: {p_value(test.p_value, '$P$')}"


def _peak(axes: Axes, course: Course) -> None:
    members = numbers(row.value for row in course.where("best_dose_set"))
    if members:
        axes.set_ylim(-0.13, 1.03)
        axes.plot(
            members,
            [-0.07] * len(members),
            linestyle="none",
            marker="^",
            markersize=4.5,
            color=INK,
            zorder=3,
            label=f"95 % set of the best {course.name}",
        )
    best, honest = course.value("best_dose"), course.value("success_at_best_dose")
    if best is not None and honest is not None:
        low, high = axes.get_xlim()
        axes.plot(
            [best + 0.025 * (high - low)],
            [honest],
            linestyle="none",
            marker="D",
            markersize=4.5,
            color=INK,
            markerfacecolor="white",
            markeredgewidth=0.9,
            zorder=5,
            label="highest share, corrected for selection",
        )
