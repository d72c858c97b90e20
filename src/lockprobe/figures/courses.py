"""The course of success over p for every agent, with its loop rate, one small panel each."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lockprobe.figures.compose import sheet
from lockprobe.figures.frame import agent_label, counts, p_axis, share_axis, title
from lockprobe.figures.palette import ACCENT, SUBJECTS, Style
from lockprobe.figures.primitives import bars, means
from lockprobe.figures.settings import own_settings
from lockprobe.rows import Course, Results

__all__ = ["courses", "draw_course"]

_SUCCESS = Style(colour=SUBJECTS[0], marker="o", dash="-", lead=True)
_LOOPS = Style(colour=ACCENT, marker="s", dash=(0, (5, 1.5)), lead=True)


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
    shares = ((_SUCCESS, "success", "solved"), (_LOOPS, "loop_rate", "with an action loop"))
    for style, quantity, label in shares:
        found = [(cell.dose or 0.0, row) for cell in course.played if (row := cell.get(quantity))]
        x, rows = [dose for dose, _ in found], [row for _, row in found]
        means(axes, x, rows, style, line=True)
        bars(axes, x, rows, style, label=label)
    kind = course.found.fact("course of success", f"{course.label}, {course.axis}")
    title(axes, agent_label(course), f"{kind}; {counts(course.played)} per {course.name}")
