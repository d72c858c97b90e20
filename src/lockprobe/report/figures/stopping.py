"""Differences block by block: the estimate with the interval that holds at every look, and where it was decided."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from lockprobe.report.figures.compose import sheet
from lockprobe.report.figures.frame import safe_name, title
from lockprobe.report.figures.palette import SUBJECTS
from lockprobe.report.figures.settings import FAINT, INK, SMALL, own_settings
from lockprobe.report.rows import Curve, Results

_MOST = 6
"""Panels that are drawn: total effects first, then the differences of agents that the study is about."""

_LONGEST = 38
"""Characters of a name above a panel."""

_WIDTH, _HEIGHT = 3.2, 2.1
"""Of a panel, in inches."""

_REACH = 60
"""The widest interval that is drawn to its ends, in points."""


@own_settings()
def stopping(found: Results) -> Figure | None:
    """A panel for each difference."""
    curves = [one for one in found.curves if one.quantity == "difference_by_block" and one.x]
    curves.sort(key=lambda one: (one.of != "total", one.agent not in found.subjects))
    shown = [(found, one) for one in curves[:_MOST]]
    wide = 5.6 if len(shown) == 1 else _WIDTH
    return sheet(shown, _draw, heights=[_HEIGHT if len(shown) > 1 else 3.0], width=wide)


def _draw(axes: Axes, panel: tuple[Results, Curve]) -> None:
    found, curve = panel
    blocks, value, low, high = (100 * np.array(of, dtype=float) for of in (curve.x, curve.value, curve.low, curve.high))
    blocks /= 100
    until, decided = found.study.get("until"), found.get("decided_at_block", agent=curve.agent, of=curve.of)
    axes.axhline(0, color=FAINT, linewidth=0.8)
    if until:
        for end in (-until["points"], until["points"]):
            axes.axhline(100 * end, color=FAINT, linewidth=0.8, linestyle=":")
    axes.fill_between(blocks, low, high, color=SUBJECTS[0], alpha=0.18, linewidth=0, step="post")
    axes.plot(blocks, value, color=SUBJECTS[0], linewidth=1.4)
    reach = min(100.0, max(_REACH, 1.25 * float(np.abs(value[len(value) // 4 :]).max())))
    axes.set_ylim(-reach, reach)
    axes.set_xlim(0, float(blocks[-1]) * 1.02 + 1)
    if decided is not None and decided.value is not None:
        axes.axvline(decided.value, color=INK, linewidth=1.0, linestyle=(0, (4, 3)))
        left = decided.value > blocks[-1] / 2
        below = float(value[-1]) > 0
        axes.annotate(
            f"{decided.note},\nblock {decided.value:.0f}",
            (decided.value, -reach if below else reach),
            (-4 if left else 4, 5 if below else -5),
            textcoords="offset points",
            ha="right" if left else "left",
            va="bottom" if below else "top",
            fontsize=SMALL,
            color=INK,
        )
    axes.xaxis.set_major_locator(MaxNLocator(5, integer=True))
    axes.set_xlabel("blocks")
    axes.set_ylabel("difference, points")
    title(axes, safe_name(curve.agent, _LONGEST), safe_name(curve.of, _LONGEST))
