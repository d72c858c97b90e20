"""Rationality of actions for an observer that believes reports and one that doubts them, with random choices."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, ScalarFormatter

from lockprobe.report.figures.compose import HEIGHT, sheet
from lockprobe.report.figures.frame import INK, dose_axes, from_to, heading, title
from lockprobe.report.figures.palette import Dash, Style, of_agent
from lockprobe.report.figures.primitives import by_dose, key, numbers, widened
from lockprobe.report.figures.settings import own_settings
from lockprobe.report.rows import Cell, Course, Results

__all__ = ["rationality"]

_LOOKS: dict[str, tuple[Style, str, Dash, float]] = {
    "naive": (Style(colour=INK), "reports believed", ":", -0.006),
    "aware": (Style(colour=INK, marker="s"), "reports doubted", "--", 0.006),
}
"""How each observer is drawn, its name in the legend, the line of chance, and how far its marks are moved sideways, in
widths of the axis, so that they stay apart."""

_LOST = "steps lost per action"


@own_settings()
def rationality(found: Results) -> Figure | None:
    """Share of optimal actions and steps lost of the agents that the study is about; None if none was judged."""
    judged = [course for course in found.courses() if course.subject and _judged(course)]
    figure = sheet(judged, _optimal_actions, _steps_lost, heights=(HEIGHT, 2.1))
    lower = [axes for axes in figure.axes if axes.get_ylabel() == _LOST] if figure else []
    top = max((axes.get_ylim()[1] for axes in lower), default=0.0)
    for axes in lower:  # one scale, so that agents can be compared
        axes.set_ylim(-0.03 * top, top)
    return figure


def _judged(course: Course) -> list[Cell]:
    """The cells whose actions were judged."""
    return [cell for cell in course.cells if cell.get("optimal_actions", "naive")]


def _optimal_actions(axes: Axes, course: Course) -> None:
    """Share of actions that no other beats, by flip probability."""
    dose_axes(axes, course, "share of optimal actions")
    _observers(axes, course, "optimal_actions")
    actions = from_to(row.n for cell in course.cells if (row := cell.get("optimal_actions", "naive")))
    said = f"n = {actions} actions per flip rate; bars: 95 % intervals"
    title(axes, heading(course), said, "dotted, dashed: by chance")


def _steps_lost(axes: Axes, course: Course) -> None:
    """Mean regret of an action in expected steps, by flip probability."""
    dose_axes(axes, course, _LOST)
    axes.set_ylim(auto=True)
    axes.yaxis.set_major_locator(MaxNLocator(4))
    axes.yaxis.set_major_formatter(ScalarFormatter())
    _observers(axes, course, "steps_lost")


def _observers(axes: Axes, course: Course, quantity: str) -> None:
    """Both observers' values with their intervals, and the lines of chance."""
    low, high = axes.get_xlim()
    judged = _judged(course)
    for white, (of, (look, name, dash, apart)) in zip((0.0, 0.4), _LOOKS.items(), strict=True):
        style = of_agent(course, look, white)
        key(axes, look, name)
        joined = {"linestyle": "-", "linewidth": 0.8}
        by_dose(axes, judged, quantity, style, of=of, shift=apart * (high - low), **joined)
        levels = numbers(cell.value(f"{quantity}_chance", of) for cell in judged)
        x, (chance,) = widened(axes, [cell.dose or 0.0 for cell in judged], levels)
        axes.plot(x, chance, color=style.colour, linestyle=dash, linewidth=0.9, zorder=2)
