"""The paper's figures, each with a companion from which conclusions may be drawn.

Drawing only: every number comes from a :class:`lockprobe.analysis.summary.StudySummary`. Each ``draw_*`` takes the
axes to draw on; ``single`` and ``panels`` make pictures of them, ``pictures`` all of a study, ``render`` files.
"""

from lockprobe.figures.settings import own_settings  # isort: skip - first of all, since it imports Matplotlib

from lockprobe.figures.compose import condition_drawings, drawings, fork_drawing, panels, pictures, render, single
from lockprobe.figures.courses import draw_course
from lockprobe.figures.differences import draw_changes, draw_differences
from lockprobe.figures.forks import fork_panels
from lockprobe.figures.loops import (
    draw_loop_harm,
    draw_loop_onset,
    draw_loops_against_success,
    draw_loops_by_p,
    draw_loops_with_chance,
)
from lockprobe.figures.people import draw_people, draw_relative_steps
from lockprobe.figures.rationality import draw_optimal_actions, draw_steps_lost
from lockprobe.figures.success_by_flip_rate import draw_success_by_p, draw_success_by_p_corrected
from lockprobe.figures.success_by_step import (
    draw_relative_success,
    draw_success_curves,
    draw_success_curves_by_p,
    draw_success_curves_corrected,
)

__all__ = [
    "condition_drawings",
    "draw_changes",
    "draw_course",
    "draw_differences",
    "draw_loop_harm",
    "draw_loop_onset",
    "draw_loops_against_success",
    "draw_loops_by_p",
    "draw_loops_with_chance",
    "draw_optimal_actions",
    "draw_people",
    "draw_relative_steps",
    "draw_relative_success",
    "draw_steps_lost",
    "draw_success_by_p",
    "draw_success_by_p_corrected",
    "draw_success_curves",
    "draw_success_curves_by_p",
    "draw_success_curves_corrected",
    "drawings",
    "fork_drawing",
    "fork_panels",
    "own_settings",
    "panels",
    "pictures",
    "render",
    "single",
]
