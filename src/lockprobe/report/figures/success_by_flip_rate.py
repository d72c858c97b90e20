"""Success by flip rate: the paper's Fig. 4, and its companion with intervals and chance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lockprobe.foundation.formatting import p_value, percent
from lockprobe.report.figures.compose import sheet
from lockprobe.report.figures.frame import (
    EXACT,
    agent_label,
    axis_note,
    blank,
    counts,
    dose_axes,
    heading,
    label_right,
    p_axis,
    share_axis,
    title,
)
from lockprobe.report.figures.palette import Style, of_agent, styles
from lockprobe.report.figures.primitives import (
    by_dose,
    curve_with_band,
    dots,
    key,
    published,
    published_by_p,
    repetitions,
    second_order_fit,
)
from lockprobe.report.figures.settings import FAINT, INK, own_settings
from lockprobe.report.rows import Course, Results
from lockprobe.statistics.published import SOLVED_AT_0, SOLVED_AT_40

_SHARE = Style(colour=INK)
"""Of the share of trials solved, where an agent is shown by itself; entries of the legend have this colour."""


@own_settings()
def fig4(found: Results) -> Figure | None:
    """Success by flip rate, as in the paper; None without an ended trial or with a single flip rate."""
    courses = _shown(found)
    return sheet([courses] if courses else [], draw_success_by_p)


@own_settings()
def fig4_corrected(found: Results) -> Figure | None:
    """The same with intervals and chance, a panel for each agent that the study is about."""
    return sheet([course for course in _shown(found) if course.subject], draw_success_by_dose)


@own_settings()
def success_by_dose(found: Results, place: int) -> Figure | None:
    """The same over another axis of the design, by its place among them.

    Agents that act the same at every dose, or were played at a single one, are left out beside others.
    """
    axis = found.design.axes[place]
    played = [course for course in found.courses(axis) if course.played]
    several = [course for course in played if len(course.played) > 1 and not course.blind]
    return sheet(several or played, draw_success_by_dose, note=axis_note(axis))


def _shown(found: Results) -> list[Course]:
    courses = found.courses()
    return courses if found.several_p and any(course.played for course in courses) else []


def draw_success_by_p(axes: Axes, courses: Sequence[Course]) -> None:
    """Success over flip probability with the second-order fit (Fig. 4).

    Dots are repetitions, markers the means. References, which the paper has not, are grey, without dots and fit.
    """
    if not any(course.played for course in courses):
        return blank(axes, "no trial has ended")
    cells, said = [cell for course in courses for cell in course.cells], [""]
    for course, style in styles(courses):
        if style.lead:
            dots(axes, [(at, success.value) for at, success, _ in repetitions(course)], style)
            said.append(second_order_fit(axes, course.curve("success_fit"), style))
        fitted = style.lead and said[-1]
        by_dose(axes, course.played, "success", style, bars=False, linestyle="none" if fitted else style.dash)
        if course.played:
            key(axes, style, heading(course).replace(", ", ",\n") if style.lead else agent_label(course))
    published(axes, published_by_p(cells, SOLVED_AT_0, SOLVED_AT_40))
    share_axis(axes, "success rate")
    p_axis(axes, cells)
    return title(axes, f"{counts(cells)} per flip rate; dots: repetitions; markers: means", max(said, key=len))


def draw_success_by_dose(axes: Axes, course: Course) -> None:
    """Fig. 4 by counts: intervals, a binomial model of the order that AICc prefers, and chance."""
    if not course.played:
        return blank(axes, f"{agent_label(course)}: no trial has ended")
    style = of_agent(course, _SHARE)
    by_dose(axes, course.played, "success", style)
    key(axes, replace(_SHARE, dash=""), "share solved with 95 % interval")
    curve, order = course.curve("success_model"), course.value("success_model_order", "AICc")
    if curve is not None and (curve := curve if curve.x[0] < curve.x[-1] else None):
        curve_with_band(axes, curve, style)
        key(axes, replace(_SHARE, marker=""), "binomial model with 95 % band")
    dose_axes(axes, course, "success rate")
    labels = []
    for of, (name, dash) in EXACT.items():
        if (level := course.value("success_chance", of)) is not None:
            axes.axhline(level, color=FAINT, linewidth=0.9, linestyle=dash, zorder=2)
            labels.append((level, f"{name}\n{percent(level)}", FAINT))
    label_right(axes, labels, gap=0.2)
    return title(
        axes,
        heading(course),
        f"{counts(course.played)} per {course.name}" + (f"; model of order {order:g} (AICc)" if curve else ""),
        _rises_and_falls(course) if len(course.played) > 1 and not course.blind else "",
    )


def _rises_and_falls(course: Course) -> str:
    """Whether success rises and then falls, by the test that is concluded from."""
    test = course.get("test", "shape")
    if test is None or test.p_value is None:
        return "rise and fall: not tested; needs three doses"
    return f"rise and fall, two-lines test: {p_value(test.p_value, '$P$')}"
