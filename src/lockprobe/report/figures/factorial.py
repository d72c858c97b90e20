"""A factorial design: the effect of every factor on misreading and on success."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lockprobe.foundation.formatting import bracketed
from lockprobe.report.figures.compose import sheet
from lockprobe.report.figures.forest import ForestRow, around, forest, height
from lockprobe.report.figures.frame import safe_name, title
from lockprobe.report.figures.palette import SUBJECTS, Style
from lockprobe.report.figures.settings import FAINT, INK, own_settings
from lockprobe.report.figures.why import change_ticks
from lockprobe.report.prose.factorial import factor_said
from lockprobe.report.rows import Estimate, Results

_LONGEST = 34
"""Characters of the agent's name."""

_WIDTH, _WIDE = 4.4, 4.0
"""Of a panel, and above a bar in it, in inches."""

_TITLE = 2
"""Lines of the title of a panel."""


@own_settings()
def factorial(found: Results) -> Figure | None:
    """A panel for each agent and measure: the effects of the factors, the largest on top."""
    panels: dict[tuple[str, str, str], list[Estimate]] = {}
    for row in found.where("factor_effect"):
        panels.setdefault((row.agent, row.modality, row.of), []).append(row)
    shown = [sorted(rows, key=lambda row: -abs(row.value or 0.0)) for rows in panels.values()]
    most = max((height(_forest(rows), _WIDE) for rows in shown), default=0.0)
    return sheet(shown, _draw, heights=[most], around=around(_TITLE), width=_WIDTH)


def _forest(rows: Sequence[Estimate]) -> list[ForestRow]:
    made = []
    for row in rows:
        style = Style(colour=SUBJECTS[0] if row.detected else FAINT, lead=row.detected)
        made.append(ForestRow(factor_said(row.axis), bracketed(row.value, row.low, row.high), row, style))
    return made


def _draw(axes: Axes, rows: list[Estimate]) -> None:
    change_ticks(axes.xaxis, rows)
    ticks = axes.get_xticks(), [tick.get_text() for tick in axes.get_xticklabels()]
    forest(axes, _forest(rows), axes.get_xlim(), levels=[(0.0, INK, "-")], wide=_WIDE)
    axes.set_xticks(*ticks)
    axes.set_xlabel(f"change of {rows[0].of}, points")
    first = rows[0]
    title(axes, safe_name(first.agent, _LONGEST), safe_name(f"{first.of}; n = {first.clusters} blocks of scenes"))
