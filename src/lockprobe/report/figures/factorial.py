"""A factorial design: the effect of every factor on misreading and on success, with its share of the variance."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lockprobe.foundation.formatting import bracketed, percent
from lockprobe.report.figures.compose import sheet
from lockprobe.report.figures.forest import ForestRow, around, forest, height
from lockprobe.report.figures.frame import FAINT, INK, safe_name, title
from lockprobe.report.figures.palette import SUBJECTS, Style
from lockprobe.report.figures.settings import own_settings
from lockprobe.report.figures.why import change_ticks
from lockprobe.report.prose.factorial import factor_said
from lockprobe.report.rows import Estimate, Results

__all__ = ["factorial"]

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
    shown = [(found, _sorted(rows)) for rows in panels.values()]
    most = max((height(_forest(*one), _WIDE) for one in shown), default=0.0)
    return sheet(shown, _draw, heights=[most], around=around(_TITLE), width=_WIDTH)


def _share(found: Results, row: Estimate) -> Estimate | None:
    return found.get("variance_share", agent=row.agent, modality=row.modality, of=row.of, axis=row.axis)


def _sorted(rows: Sequence[Estimate]) -> list[Estimate]:
    return sorted(rows, key=lambda row: -abs(row.value or 0.0))


def _forest(found: Results, rows: Sequence[Estimate]) -> list[ForestRow]:
    made = []
    for row in rows:
        share = _share(found, row)
        of = f"; {percent(share.value)}" if share and share.low else ""
        style = Style(colour=SUBJECTS[0] if row.detected else FAINT, lead=row.detected)
        made.append(ForestRow(factor_said(row.axis), f"{bracketed(row.value, row.low, row.high)}{of}", row, style))
    return made


def _draw(axes: Axes, panel: tuple[Results, list[Estimate]]) -> None:
    found, rows = panel
    change_ticks(axes.xaxis, rows)
    ticks = axes.get_xticks(), [tick.get_text() for tick in axes.get_xticklabels()]
    forest(axes, _forest(found, rows), axes.get_xlim(), levels=[(0.0, INK, "-")], wide=_WIDE)
    axes.set_xticks(*ticks)
    axes.set_xlabel(f"change of {rows[0].of}, points; share of variance")
    first = rows[0]
    title(axes, safe_name(first.agent, _LONGEST), safe_name(f"{first.of}; n = {first.clusters} blocks of scenes"))
