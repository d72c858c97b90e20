"""The paper's figures. Drawing only: every number comes from a :class:`lockprobe.analysis.summary.StudySummary`.

Each ``draw_*`` takes the axes to draw on; ``single`` and ``panels`` make pictures of them, ``render`` files.
"""

from lockprobe.figures.draw import (
    draw_loops_against_success,
    draw_loops_by_p,
    draw_success_by_p,
    draw_success_curves,
    draw_success_curves_by_p,
)
from lockprobe.figures.frame import panels, render, single

__all__ = [
    "draw_loops_against_success",
    "draw_loops_by_p",
    "draw_success_by_p",
    "draw_success_curves",
    "draw_success_curves_by_p",
    "panels",
    "render",
    "single",
]
