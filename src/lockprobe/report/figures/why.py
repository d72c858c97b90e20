"""Why false reports change success: success by first and last statement, and the differences between arms."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from lockprobe.foundation.formatting import bracketed, percent, points
from lockprobe.report.figures.compose import sheet
from lockprobe.report.figures.frame import safe_name, title
from lockprobe.report.figures.palette import SUBJECTS, Style
from lockprobe.report.figures.primitives import estimates
from lockprobe.report.figures.settings import FAINT, INK, SMALL, own_settings
from lockprobe.report.prose.subject import Subject
from lockprobe.report.rows import Estimate, Results

_COLOURS = mpl.colormaps["Blues"]

_DARK = 0.78
"""Share from which on white is easier to read on its colour than ink."""

_LONGEST = 38
"""Characters of the agent's name."""

_WIDTH, _GRID, _ROW, _AROUND = 4.6, 1.6, 0.24, 0.78
"""Width of a panel; height of the squares, of a difference, and of what stands around both; in inches."""

_COLUMNS = 2
"""Panels beside each other."""

_LABELS = 1.3
"""Room for the names of differences, as a share of the width that the differences have."""

_CELLS = {
    "truth": (0.0, -1 / 6, 2 / 3),
    "lie": (0.0, 0.5, 2 / 3),
    "remark": (0.0, 7 / 6, 2 / 3),
    "truth-truth": (1.25, 0.0, 1.0),
    "truth-lie": (2.25, 0.0, 1.0),
    "lie-truth": (1.25, 1.0, 1.0),
    "lie-lie": (2.25, 1.0, 1.0),
}
"""Arm -> the middle of its cell, across and from the top, and its height; the last four are the crossing."""

_NAMES = {"truth": "true reports", "lie": "false reports", "remark": "true, and a remark"}
"""What stands in the cells of plain reports."""


@dataclass(frozen=True, slots=True)
class _Panel:
    """An agent: the total effect, what is shown below the arms, and how many rows its neighbours have at most."""

    total: Estimate
    shown: Sequence[Estimate]
    rows: int = 0


@own_settings()
def why(found: Results) -> Figure | None:
    """Success in the arms at the top and differences below, a panel for each agent."""
    asked = found.where("false_report_effect", of="total")
    panels = [_Panel(total, _differences(found, total)) for total in asked]
    bands = [panels[i : i + _COLUMNS] for i in range(0, len(panels), _COLUMNS)]
    heights = [height for band in bands for height in (_GRID, _ROW * max(len(one.shown) for one in band))]
    reach = max((_reach(one.shown) for one in panels), default=0.0)
    draws = partial(_draw_arms, found), partial(_draw_differences, reach=reach)
    shown = [replace(one, rows=max(len(beside.shown) for beside in band)) for band in bands for one in band]
    return sheet(shown, *draws, heights=heights, around=_AROUND, columns=_COLUMNS, width=_WIDTH, cells=True)


def _differences(found: Results, total: Estimate) -> list[Estimate]:
    """The total effect, and the contrasts of arms where there are any."""
    return [total, *found.where("arm_contrast", agent=total.agent, modality=total.modality)]


def _draw_arms(found: Results, axes: Axes, panel: _Panel) -> None:
    """Success in every arm as a cell with its interval; darker is more."""
    total = panel.total
    arms = {one.of: one for one in found.where("success_in_arm", agent=total.agent, modality=total.modality)}
    for arm, (across, down, height) in _CELLS.items():
        if arm not in arms:
            continue
        share, value = arms[arm], arms[arm].value or 0.0
        corner, colour = (across - 0.5, down - height / 2), _COLOURS(0.85 * value)
        axes.add_patch(Rectangle(corner, 1, height, facecolor=colour, edgecolor="white", linewidth=1.5))
        within = f"[{100 * (share.low or 0):.0f}, {100 * (share.high or 0):.0f}]"
        text = f"{percent(value)} {within}" if arm in _NAMES else f"{percent(value)}\n{within}"
        text = f"{_NAMES[arm]}\n{text}" if arm in _NAMES else text
        ink = "white" if value > _DARK else INK
        axes.text(across, down, text, ha="center", va="center", color=ink, fontsize=SMALL, linespacing=1.25)
    axes.set(xlim=(-0.52, 2.77), ylim=(1.52, -0.52))
    axes.set_xticks([0, 1.25, 2.25], ["plain reports", "last is true", "last is false"])
    axes.set_yticks([])
    for down, text in enumerate(("first is true", "first is false")):
        axes.text(0.71, down, text, ha="right", va="center", rotation=90, fontsize=SMALL, color=INK)
    axes.spines[:].set_visible(False)
    axes.tick_params(length=0)
    trials = dict.fromkeys((min(one.n or 0 for one in arms.values()), max(one.n or 0 for one in arms.values())))
    per_arm = "\N{EN DASH}".join(map(str, trials))
    rate = f"rate {total.doses['flip.p']:g}; n = {per_arm} per arm"
    title(axes, safe_name(Subject.of(total.agent).name, _LONGEST), rate)


def _draw_differences(axes: Axes, panel: _Panel, reach: float) -> None:
    """The total effect and the contrasts of arms, in points, from the top, on one axis for all agents."""
    total, shown = panel.total, panel.shown
    bottom = len(shown) - 0.4
    axes.plot([0, 0], [bottom, -0.6], color=FAINT, linewidth=0.8, zorder=1)
    for place, one in enumerate(shown):
        style = Style(colour=INK if one is total else SUBJECTS[0], lead=one is total)
        estimates(axes, [place], [one], style, across=True, markersize=5, elinewidth=1.4)
    axes.set(ylim=(panel.rows - 0.4, -0.6), yticks=[])
    if len(shown) < panel.rows:
        axes.spines["bottom"].set_position(("data", bottom))
    _change_ticks(axes.xaxis, reach)
    low, high = axes.get_xlim()
    axes.set_xlim(low - _LABELS * (high - low), high)
    for place, name in enumerate(["false reports", *(one.of for one in shown[1:])]):
        axes.text(0, place, name, transform=axes.get_yaxis_transform(), va="center", fontsize=SMALL, color=INK)
    axes.spines["left"].set_visible(False)
    axes.spines["bottom"].set_bounds(low, high)
    axes.set_xlabel("change of success, points", loc="right")
    title(axes, "Differences between arms", bracketed(total.value or 0.0, total.low, total.high))


def change_ticks(axis: Axis, changes: Iterable[Estimate]) -> None:
    """Limits and ticks for changes of success, as far in both directions as they and their intervals need."""
    _change_ticks(axis, _reach(changes))


def _reach(changes: Iterable[Estimate]) -> float:
    return max(0.2, *(1.1 * abs(end or 0) for one in changes for end in (one.low, one.high, one.value)))


def _change_ticks(axis: Axis, reach: float) -> None:
    step = 0.5 if reach > 0.6 else 0.2 if reach > 0.3 else 0.1
    ticks = [i * step for i in range(-int(reach / step), int(reach / step) + 1)]
    axis.set_view_interval(-reach, reach, ignore=True)
    axis.set_ticks(ticks, labels=[points(tick) if tick else "0" for tick in ticks])
