"""Differences in points or in steps, a row each: of conditions, agents, factors and studies.

A filled mark is a difference that was detected.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from lockprobe.foundation.formatting import bracketed, minus
from lockprobe.report.figures.compose import sheet
from lockprobe.report.figures.forest import ForestRow, around, forest, height
from lockprobe.report.figures.frame import title, title_lines
from lockprobe.report.figures.palette import SUBJECTS, Marker, Style
from lockprobe.report.figures.primitives import Interval
from lockprobe.report.figures.settings import FAINT, own_settings
from lockprobe.report.rows import Estimate

_WIDEST = 1.5
"""Width of an interval of points from which on it says nothing and is not drawn; chosen by eye."""


@dataclass(frozen=True, slots=True)
class Panel:
    """Differences around a line at none, in points or in steps. An axis without a label has no numbers either.

    ``room`` is the height of the axes, where they stand beside some with more rows.
    """

    rows: Sequence[ForestRow]
    label: str
    title: Sequence[str]
    reach: float
    steps: bool = False
    room: float = 0.0

    @classmethod
    def of(
        cls, rows: Sequence[ForestRow], *titles: str, label: str = "difference, points", steps: bool = False
    ) -> Panel:
        """Rows with an axis that holds them all, and at least 10 points or a step."""
        ends = (end for row in rows for end in (row.found.value, row.found.low, row.found.high))
        reach = max([1.0 if steps else 0.1, *(abs(end) for end in ends if end is not None)])
        return cls(rows, label, titles, 1.06 * reach, steps)


@own_settings()
def panels_sheet(panels: Sequence[Panel], columns: int, note: str = "") -> Figure | None:
    """Panels of one unit on one axis, so that they can be compared, each row of them as high as the longest in it."""
    bands = [panels[i : i + columns] for i in range(0, len(panels), columns)]
    heights = [max(height(one.rows) for one in band) for band in bands]
    reach = {unit: max((one.reach for one in panels if one.steps == unit), default=0.0) for unit in (False, True)}
    shown = [
        replace(one, room=room, reach=reach[one.steps])
        for band, room in zip(bands, heights, strict=True)
        for one in band
    ]
    lines = max((len(title_lines(*one.title)) for one in panels), default=0)
    return sheet(shown, _draw, columns=columns, heights=heights, around=around(lines), note=note)


def _draw(axes: Axes, panel: Panel) -> None:
    reach, scale = panel.reach, 1 if panel.steps else 100
    forest(axes, panel.rows, (-reach, reach), levels=((0.0, FAINT, "-"),), room=panel.room)
    ticks = range(-200, 201, 50 if reach > 0.6 else 25 if reach > 0.25 else 10)
    places = MaxNLocator(4, integer=True).tick_values(-reach, reach) if panel.steps else ticks
    inside = [int(tick) for tick in places if abs(tick) <= scale * reach]
    names = [minus(f"{tick:+d}") if tick else "0" for tick in inside] if panel.label else [""] * len(inside)
    axes.set_xticks([tick / scale for tick in inside], names)
    axes.set_xlabel(panel.label)
    title(axes, *panel.title)


def difference(
    name: str,
    found: Interval,
    *,
    detected: bool,
    unit: str = "points",
    where: str = "",
    colour: str = SUBJECTS[0],
    marker: Marker = "o",
) -> ForestRow:
    """A row of a difference, its numbers after ``where``; one whose interval in points says nothing has no mark."""
    style = Style(colour=colour, marker=marker, lead=detected)
    if unit == "steps":
        return ForestRow(name, where + bracketed(found.value, found.low, found.high, "{:+.1f}", 1), found, style)
    if found.low is not None and found.high is not None and found.high - found.low > _WIDEST:
        few = f"{where}too few trials to compare"
        return ForestRow(name, few, Estimate(quantity="none"), replace(style, lead=False))
    return ForestRow(name, where + bracketed(found.value, found.low, found.high), found, style)
