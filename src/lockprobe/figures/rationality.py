"""Rationality of actions for an observer that believes reports and one that doubts them, with random choices."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, ScalarFormatter

from lockprobe.figures.compose import HEIGHT, sheet
from lockprobe.figures.frame import heading, p_axis, share_axis, title
from lockprobe.figures.palette import ACCENT, SUBJECTS, Dash, Style
from lockprobe.figures.primitives import numbers
from lockprobe.figures.settings import own_settings
from lockprobe.rows import Cell, Course, Estimate, Results

__all__ = ["rationality"]

_LOOKS: dict[str, tuple[Style, str, Dash]] = {
    "naive": (Style(colour=SUBJECTS[0], marker="o", dash="-", lead=True), "reports believed", ":"),
    "aware": (Style(colour=ACCENT, marker="s", dash="-", lead=True), "reports doubted", "--"),
}
"""How each observer is drawn, its name in the legend, and the line of chance."""

_APART = {"naive": -0.006, "aware": 0.006}
"""Sideways shifts that keep the marks of the observers apart, in widths of the axis."""


@own_settings()
def rationality(found: Results) -> Figure | None:
    """Share of optimal actions and steps lost of the agents that the study is about; None if none was judged."""
    judged = [course for course in found.courses() if course.subject and _judged(course)]
    return sheet(judged, _optimal_actions, _steps_lost, heights=(HEIGHT, 2.1)) if judged else None


def _judged(course: Course) -> list[Cell]:
    """The cells whose actions were judged."""
    return [cell for cell in course.cells if cell.get("optimal_actions", "naive")]


def _optimal_actions(axes: Axes, course: Course) -> None:
    """Share of actions that no other beats, by flip probability."""
    share_axis(axes, "share of optimal actions")
    p_axis(axes, course.cells)
    for of in _LOOKS:
        _observer(axes, _judged(course), "optimal_actions", of)
    sizes = sorted({row.n or 0 for cell in course.cells if (row := cell.get("optimal_actions", "naive"))})
    several = f"{sizes[0]} to {sizes[-1]}" if len(sizes) > 1 else f"{sizes[0]}"
    said = f"n = {several} actions per flip rate; bars: 95 % intervals"
    title(axes, heading(course), said, "dotted, dashed: by chance")


def _steps_lost(axes: Axes, course: Course) -> None:
    """Mean regret of an action in expected steps, by flip probability."""
    share_axis(axes, "steps lost per action")
    p_axis(axes, course.cells)
    axes.set_ylim(auto=True)
    axes.yaxis.set_major_locator(MaxNLocator(4))
    axes.yaxis.set_major_formatter(ScalarFormatter())
    for of in _LOOKS:
        _observer(axes, _judged(course), "steps_lost", of)
    axes.set_ylim(bottom=-0.03 * axes.get_ylim()[1])


def _observer(axes: Axes, judged: Sequence[Cell], quantity: str, of: str) -> None:
    """One observer's values with their intervals, and the line of chance."""
    (style, name, dash), x = _LOOKS[of], [cell.dose or 0.0 for cell in judged]
    rows = [row for cell in judged if (row := cell.get(quantity, of))]
    low, high = axes.get_xlim()
    axes.errorbar(
        [p + _APART[of] * (high - low) for p in x],
        numbers(row.value for row in rows),
        yerr=[*zip(*map(_reach, rows), strict=True)],
        fmt="",
        marker=style.marker,
        color=style.colour,
        linestyle="-",
        linewidth=0.8,
        markersize=4.6,
        markeredgecolor="white",
        markeredgewidth=0.7,
        elinewidth=1.1,
        zorder=4,
        label=name,
    )
    chance, reach = numbers(cell.value(f"{quantity}_chance", of) for cell in judged), 0.04 * (high - low)
    ends = x if len(x) > 1 else [x[0] - reach, x[0] + reach]
    axes.plot(ends, chance * (len(ends) // len(x)), color=style.colour, linestyle=dash, linewidth=0.9, zorder=2)


def _reach(row: Estimate) -> tuple[float, float]:
    """How far its interval reaches down and up; nowhere at an end that is not known."""
    value = row.value or 0.0
    low, high = (value if end is None else end for end in (row.low, row.high))
    return max(0.0, value - low), max(0.0, high - value)
