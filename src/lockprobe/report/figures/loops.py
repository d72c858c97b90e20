"""Loops: the paper's Figs. 5a and 5b, and a companion with chance levels and onset."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lockprobe.foundation.formatting import bracketed, p_value
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
    share_axis,
    share_ticks,
    step_axis,
    title,
)
from lockprobe.report.figures.palette import Style, of_agent
from lockprobe.report.figures.primitives import (
    band,
    by_dose,
    dots,
    numbers,
    published,
    published_by_p,
    repetitions,
    second_order_fit,
    staircase,
    widened,
)
from lockprobe.report.figures.settings import FAINT, INK, own_settings
from lockprobe.report.rows import Cell, Course, Curve, Estimate, Results
from lockprobe.statistics.published import LOOPS_AT_0, LOOPS_AT_40

_OWN = Style(colour=INK)
"""Loop rates, or the lowest flip rate, in the colour of the agent."""

_HIGHER = Style(colour=INK, marker="s", dash=(0, (5, 1.5)))
"""All flip rates but the lowest."""

_LENGTH_NOTE = (
    "Solved trials are shorter and hold fewer loops by chance alone: a negative r is expected even if loops do no harm."
)


@own_settings()
def loops_against_success(found: Results) -> Figure | None:
    """Loop rate against success, as in the paper's Fig. 5a; None with a single flip rate."""
    return sheet(_subjects(found) if found.several_p else [], _against_success, note=_LENGTH_NOTE)


@own_settings()
def loops_by_p(found: Results) -> Figure | None:
    """Loop rate by flip rate, as in the paper's Fig. 5b; None with a single flip rate."""
    return sheet(_subjects(found) if found.several_p else [], _by_p)


@own_settings()
def loops_with_chance(found: Results) -> Figure | None:
    """Loop rates with their chance levels, and below them when the first loop is complete."""
    shown = _subjects(found)
    onset = [_draw_onset] if any(_onset(course, "lowest") for course in shown) else []
    return sheet(shown, _with_chance, *onset)


@own_settings()
def loops_by_dose(found: Results, place: int) -> Figure | None:
    """Loop rates with their chance levels over another axis of the design, by its place among them."""
    axis = found.design.axes[place]
    return sheet([course for course in found.courses(axis) if course.played], _with_chance, note=axis_note(axis))


def _subjects(found: Results) -> list[Course]:
    """The agents that the study is about; none if no trial has ended."""
    courses = found.courses()
    return [one for one in courses if one.subject] if any(one.played for one in courses) else []


def _against_success(axes: Axes, course: Course) -> None:
    """Loop rate against success over repetitions, with the regression line and r (Fig. 5a)."""
    shown = course.cells[:1] if course.blind else course.cells
    points = [(loops.value or 0.0, success.value or 0.0) for cell in shown for success, loops in cell.points]
    if not points:
        return blank(axes, f"{agent_label(course)}: no trial has ended")
    dots(axes, points, of_agent(course, _OWN), size=16)
    slope, intercept = (course.value("loop_success_line", of) for of in ("slope", "intercept"))
    if slope is not None and intercept is not None:
        ends = [min(points)[0], max(points)[0]]
        axes.plot(ends, [intercept + slope * x for x in ends], color=INK, linewidth=1.2, zorder=2)
    found = course.get("loop_success_correlation")
    title(axes, heading(course), f"{_r(found)}; n = {found.n if found else 0} dots")
    axes.set(xlim=(-0.04, 1.04), xlabel="share of trials with an action loop")
    share_ticks(axes.xaxis)
    return share_axis(axes, "success rate")


def _r(found: Estimate | None) -> str:
    if found is None or found.value is None:
        return "r is not defined"
    return f"r = {bracketed(found.value, found.low, found.high, '{:.2f}', 1)}"


def _by_p(axes: Axes, course: Course) -> None:
    """Loop rate over flip probability with the second-order fit (Fig. 5b)."""
    if not course.played:
        return blank(axes, f"{agent_label(course)}: no trial has ended")
    own = of_agent(course, _OWN)
    fitted = second_order_fit(axes, course.curve("loop_fit"), own)
    dots(axes, [(dose, loops.value) for dose, _, loops in repetitions(course)], own)
    by_dose(axes, course.played, "loop_rate", own, bars=False, linestyle="none" if fitted else "-")
    published(axes, published_by_p(course.cells, LOOPS_AT_0, LOOPS_AT_40), "the paper, reconstructed")
    dose_axes(axes, course, "action loop probability")
    said = f"{counts(course.played)} per flip rate; dots: repetitions; markers: means"
    return title(axes, heading(course), said, fitted)


def _with_chance(axes: Axes, course: Course) -> None:
    """Fig. 5b with intervals and what chance alone gives in trials of exactly these lengths."""
    if not course.played:
        return blank(axes, f"{agent_label(course)}: no trial has ended")
    by_dose(axes, course.played, "loop_rate", of_agent(course, _OWN))
    dose_axes(axes, course, "share of trials with a loop")
    _blind_agents(axes, [cell.dose or 0.0 for cell in course.played], course)
    return title(
        axes,
        heading(course),
        f"{counts(course.played)} per {course.name}; bars: 95 % intervals",
        "chance: grey",
    )


def _chance(course: Course, of: str) -> list[float]:
    """The loop rate by chance under a null model, at every dose with an ended trial."""
    return numbers(cell.value("loop_rate_chance", of) for cell in course.played)


def _blind_agents(axes: Axes, x: Sequence[float], course: Course) -> None:
    """Between the two blind agents; a single p is given some width to be seen."""
    ends, levels = widened(axes, x, *(_chance(course, of) for of in EXACT))
    axes.fill_between(ends, levels[0], levels[1], color="#999999", alpha=0.2, linewidth=0, zorder=1)
    labels = []
    for level, (name, dash) in zip(levels, EXACT.values(), strict=True):
        axes.plot(ends, level, linestyle=dash, color=FAINT, linewidth=0.9, zorder=2)
        labels.append((level[-1], name, FAINT))
    label_right(axes, labels)


def _draw_onset(axes: Axes, course: Course) -> None:
    """When the first loop is complete: the lowest p against all higher ones, one minus Kaplan-Meier."""
    lowest, higher = _onset(course, "lowest"), _onset(course, "higher")
    if lowest is None or higher is None:
        why = "the same at every flip rate" if course.blind else "fewer than two flip rates with trials"
        return blank(axes, f"{agent_label(course)}: no comparison of loop onsets ({why})")
    first, *others = _compared(course)
    groups = ((lowest, [first], of_agent(course, _OWN)), (higher, others, of_agent(course, _HIGHER, 0.4)))
    for i, (curve, _, style) in enumerate(groups):
        staircase(axes, curve.value, style, first=1 + 2 * i)
        band(axes, curve.low, curve.high, style)
    step_axis(axes, max(len(curve.x) - 1 for curve, _, _ in groups), "looped by this step")
    ends = [(numbers(curve.value)[-1], _group(p, curve.n), style.colour) for curve, p, style in groups]
    label_right(axes, ends, gap=0.2)
    found = course.get("hazard_ratio_of_first_loop")
    ratio = "not defined" if found is None or found.value is None else f"{found.value:.2f}"
    return title(
        axes,
        agent_label(course),
        f"hazard ratio {ratio}, log-rank: {p_value(found.p_value if found else None, '$P$')}",
        "1 \N{MINUS SIGN} Kaplan-Meier, censored at success; 95 % bands",
    )


def _onset(course: Course, of: str) -> Curve | None:
    own = {"agent": course.agent, "modality": course.modality, "condition": ""}
    return course.found.curve("loop_onset", **own, axis="step", of=of)


def _compared(course: Course) -> list[float]:
    """The doses that are compared: the lowest, and the others at which something was changed."""
    acting = [course.cells[0], *(cell for cell in course.cells[1:] if not _never_acted(cell))]
    return [cell.dose for cell in acting if cell.trials and cell.dose is not None]


def _group(p: Sequence[float], n: int | None) -> str:
    return f"$p$ = {p[0]:g}{'' if len(p) == 1 else f' to {p[-1]:g}'}\nn = {n}"


def _never_acted(cell: Cell) -> bool:
    success = cell.get("success")
    return success is not None and success.note == "never acted"
