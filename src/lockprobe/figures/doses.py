"""Success and loops over another dose than flip rates."""

from __future__ import annotations

from matplotlib.figure import Figure

from lockprobe.figures.compose import sheet
from lockprobe.figures.loops import draw_loops_with_chance
from lockprobe.figures.settings import own_settings
from lockprobe.figures.success_by_flip_rate import draw_success_by_dose
from lockprobe.rows import Course, Results

__all__ = ["loops_by_dose", "success_by_dose"]


@own_settings()
def success_by_dose(found: Results, place: int) -> Figure | None:
    """Success over an axis, by its place among the axes of the design; None if no trial has ended."""
    courses = _played(found, place)
    return sheet(courses, draw_success_by_dose) if courses else None


@own_settings()
def loops_by_dose(found: Results, place: int) -> Figure | None:
    """The loop rate over an axis, with what chance gives."""
    courses = _played(found, place)
    return sheet(courses, draw_loops_with_chance) if courses else None


def _played(found: Results, place: int) -> list[Course]:
    return [course for course in found.courses(found.design.axes[place]) if course.played]
