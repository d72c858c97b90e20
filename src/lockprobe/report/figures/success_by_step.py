"""Success by step: the paper's Fig. 3, its companions with chance and the optimum, and one curve for each flip rate."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lockprobe.foundation.formatting import bracketed
from lockprobe.report.figures.compose import HEIGHT, sheet
from lockprobe.report.figures.forest import ForestRow, around, forest, height
from lockprobe.report.figures.frame import EXACT, agent_label, blank, counts, heading, label_right, step_axis, title
from lockprobe.report.figures.palette import Dash, Style, styles
from lockprobe.report.figures.primitives import band, published, staircase
from lockprobe.report.figures.settings import FAINT, INK, own_settings
from lockprobe.report.rows import Cell, Course, Curve, Estimate, Results
from lockprobe.statistics.published import REFERENCE_STEPS, STEPS_TO_80

_NAMED = 11
"""Curves whose names fit at the right edge without overlap."""

_WIDE = 2.8
"""Width above the bars of areas, which stand below the curves, in inches."""

_BRIGHTEST = 0.75
"""Where the colours of flip rates end in a map of Matplotlib; beyond, they are too bright for lines on white."""

_MIDDLE = "trials broke: middle of the bounds"
"""What a curve is where trials broke."""

_TITLE = 2
"""Lines of the titles above the curves and the areas."""

_OPTIMUM: Dash = (0, (8, 3))
"""How the shortest plan is drawn."""

_Shown = Sequence[tuple[Course, Style, Cell, Curve]]
"""Agents with a curve, how each is drawn, and its curve at its lowest p."""


@own_settings()
def success_curves(found: Results) -> Figure | None:
    """Success by number of interactions, one staircase per agent and modality at its lowest p (Fig. 3)."""
    shown = _at_the_lowest_p(found)
    return sheet([shown] if shown else [], _curves)


@own_settings()
def success_curves_corrected(found: Results) -> Figure | None:
    """Fig. 3 between chance and the optimum, and every agent's area between them, as far as it has one."""
    if not _at_the_lowest_p(found):
        return None
    rows = _area_rows(found)
    if all(row.found.value is None for row in rows):
        return sheet([found], _curves_corrected)
    beside = around(_TITLE)
    return sheet([found], _curves_corrected, _areas, heights=[HEIGHT - beside, height(rows, _WIDE)], around=beside)


@own_settings()
def success_curves_by_p(found: Results) -> Figure | None:
    """Success by step, one line per p, a panel for each agent that the study is about."""
    drawn = found.several_p and _at_the_lowest_p(found)
    return sheet([course for course in found.courses() if course.subject] if drawn else [], _curves_of)


def _at_the_lowest_p(found: Results) -> _Shown:
    return [(course, style, *first) for course, style in styles(found.courses()) for first in _counted(course)[:1]]


def _counted(course: Course) -> list[tuple[Cell, Curve]]:
    """Its cells that have a curve."""
    return [(cell, curve) for cell in course.cells if (curve := cell.curve("success_by_step")) is not None]


def _curves(axes: Axes, shown: _Shown) -> None:
    said, budget = _staircases(axes, shown), _budget(shown)
    if all(cell.p == 0 for _, _, cell, _ in shown):
        steps = sorted({REFERENCE_STEPS, *STEPS_TO_80.values()})
        published(axes, [(step, 0.8) for step in steps if step <= budget])
    step_axis(axes, budget, "success probability")
    title(axes, said)


def _curves_corrected(axes: Axes, found: Results) -> None:
    """Curves with bands, exact blind agents, shortest plan; references have no band."""
    shown = _at_the_lowest_p(found)
    said, budget = _staircases(axes, shown), _budget(shown)
    for _, style, _, curve in shown:
        if style.lead:
            band(axes, curve.low, curve.high, style)
    _exact_curves(axes, found, budget)
    step_axis(axes, budget, "solved by this step")
    broke = any(cell.value("broken") for _, _, cell, _ in shown)
    curves = _MIDDLE if broke else "1 \N{MINUS SIGN} Kaplan-Meier"
    title(axes, said, f"{curves}; shade: pointwise 95 % band")


def _staircases(axes: Axes, shown: _Shown) -> str:
    """One curve for each agent; the p and number of trials if all have the same, else each label names its own."""
    alike = len({(cell.p, curve.n) for _, _, cell, curve in shown}) == 1
    for i, (course, style, cell, curve) in enumerate(shown):
        told = "" if alike else f",\n$p$ = {cell.p:g}, n = {curve.n}"
        staircase(axes, curve.value, style, label=agent_label(course) + told, first=1 + i % 4)
    _, _, first, curve = shown[0]
    where = f"flip rate {first.p:g}" if first.p else "true reports"
    return f"{where}; {counts([curve])} of each agent" if alike else ""


def _budget(shown: _Shown) -> int:
    return max(len(curve.x) - 1 for *_, curve in shown)


def _exact_curves(axes: Axes, found: Results, budget: int) -> None:
    for of, (name, dash) in EXACT.items():
        if (exact := found.curve("success_by_step", of=of)) is not None:
            style = Style(colour=FAINT, marker="", dash=dash, lead=False)
            staircase(axes, exact.value[: budget + 1], style, label=f"{name} (exact)")
    if (optimum := found.get("optimum")) is not None and optimum.value is not None:
        label = f"shortest plan: {optimum.value:g} steps"
        axes.axvline(optimum.value, color=INK, linewidth=0.7, linestyle=_OPTIMUM, zorder=1, label=label)


def _area_rows(found: Results) -> list[ForestRow]:
    """Every agent's area at its lowest p."""
    rows, none = [], Estimate(quantity="relative_area")
    for course, style in styles(found.courses()):
        area = next((cell.get("relative_area") for cell, _ in _counted(course)), None) or none
        said = "not defined" if area is none else bracketed(area.value, area.low, area.high, "{:.2f}", 1)
        rows.append(ForestRow(agent_label(course), said, area, style))
    return rows


def _areas(axes: Axes, found: Results) -> None:
    """How far every agent's curve at its lowest p lies from chance (0) to the shortest plan (1), by area."""
    rows = _area_rows(found)
    ends = [0.0, 1.0, *(end for row in rows for end in (row.found.low, row.found.high) if end is not None)]
    levels = ((0.0, FAINT, ":"), (1.0, INK, _OPTIMUM))
    forest(axes, rows, (min(ends) - 0.05, max(ends) + 0.05), left=-0.2, levels=levels, wide=_WIDE)
    axes.set_xticks([0, 0.5, 1], ["0\nrandom", "0.5", "1\nshortest plan"])
    title(axes, "area under the curve; bars: 95 % intervals")


def _curves_of(axes: Axes, course: Course) -> None:
    """One line per p; bands for the lowest p and the one that differs most clearly from it.

    Of more than eleven p only those two, the lowest and the highest are named; colours run from the lowest up.
    """
    counted = _counted(course)[: 1 if course.blind else None]
    if not counted:
        return blank(axes, f"{agent_label(course)}: no trial has ended")
    doses = [cell.dose for cell, _ in counted]
    banded = _contrast(course) or doses[:1]
    named = doses if len(doses) <= _NAMED else [doses[0], doses[-1], *banded]
    labels: list[tuple[float, str, str]] = []
    for i, (cell, curve) in enumerate(counted):
        colour = mpl.colors.to_hex(mpl.colormaps["viridis"](_BRIGHTEST * i / max(1, len(counted) - 1)))
        style = Style(colour=colour, marker="")
        staircase(axes, curve.value, style)
        if cell.dose in banded:
            band(axes, curve.low, curve.high, style)
        if cell.dose in named:
            labels.append((curve.value[-1] or 0.0, "all $p$" if course.blind else f"$p$ = {cell.p:g}", colour))
    step_axis(axes, len(counted[0][1].x) - 1, "solved by this step")
    said = f"{counts([curve for _, curve in counted])} per {course.name}; shade: pointwise 95 % band"
    title(axes, heading(course), said, _MIDDLE if any(cell.value("broken") for cell, _ in counted) else "")
    return label_right(axes, labels)


def _contrast(course: Course) -> list[float | None]:
    """The lowest p and the one that differs most clearly from it; none if no two were compared."""
    clearest = course.value("clearest_dose")
    return [] if clearest is None else [course.value("lowest_dose"), clearest]
