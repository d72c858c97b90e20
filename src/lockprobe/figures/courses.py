"""The course of success over p for every agent, with its loop rate, one small panel each."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lockprobe.figures.compose import sheet
from lockprobe.figures.frame import agent_label, counts, p_axis, share_axis, title
from lockprobe.figures.palette import ACCENT, SUBJECTS, Style
from lockprobe.figures.primitives import by_dose
from lockprobe.figures.settings import own_settings
from lockprobe.rows import Course, Results

__all__ = ["courses", "draw_course"]

_SHARES = {
    "success": (Style(colour=SUBJECTS[0]), "solved"),
    "loop_rate": (Style(colour=ACCENT, marker="s", dash=(0, (5, 1.5))), "with an action loop"),
}
"""What is drawn, how, and its name in the legend."""


@own_settings()
def courses(found: Results) -> Figure | None:
    """A panel for each agent; None for a single agent or a single flip rate."""
    shown = found.courses()
    if len(shown) < 2 or not found.several_p or not any(course.played for course in shown):
        return None
    return sheet(shown, draw_course, heights=(2.1,))


def draw_course(axes: Axes, course: Course) -> None:
    """Success and loop rate by flip probability, with the course that the tests detect."""
    share_axis(axes, "share of trials")
    p_axis(axes, course.cells, name=course.name)
    for quantity, (style, label) in _SHARES.items():
        by_dose(axes, course.played, quantity, style, linestyle=style.dash, label=label)
    kind = course.found.fact("course of success", f"{course.label}, {course.axis}")
    title(axes, agent_label(course), f"{kind}; {counts(course.played)} per {course.name}")
