"""From pictures to flips: steps more than in words, in pictures and in words with misreadings told as false reports."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lockprobe.report.figures.compose import sheet
from lockprobe.report.figures.forest import ForestRow, around, forest, height
from lockprobe.report.figures.frame import FAINT, INK, safe_name, title
from lockprobe.report.figures.palette import SUBJECTS, Dash, Style
from lockprobe.report.figures.settings import own_settings
from lockprobe.report.prose.bridge import steps_said
from lockprobe.report.rows import Estimate, Results
from lockprobe.report.table_rows import share_of_row
from lockprobe.statistics.bridge.arms import PICTURES
from lockprobe.statistics.conditions.modalities import spoken

__all__ = ["bridge"]

_LONGEST = 34
"""Characters of the agent's name."""

_WIDTH, _WIDE = 4.4, 4.0
"""Of a panel, and above a bar in it, in inches."""

_TITLE = 2
"""Lines of the title of a panel."""

_NAMES = {
    PICTURES: "pictures",
    "replayed": "its misreadings, one by one",
    "shuffled": "as many at random steps",
    "profile": "flips by joint and direction",
    "symmetric": "flips at the total rate",
}
"""What stands above each bar."""


@own_settings()
def bridge(found: Results) -> Figure | None:
    """A panel for each agent and way to see: the changes of its arms, pictures on top."""
    panels: dict[tuple[str, str], list[Estimate]] = {}
    for row in found.where("steps_difference"):
        if row.of in _NAMES:
            panels.setdefault((row.agent, row.modality), []).append(row)
    shown = [(found, rows) for rows in panels.values()]
    most = max((height(_forest(*one), _WIDE) for one in shown), default=0.0)
    return sheet(shown, _draw, heights=[most], around=around(_TITLE), width=_WIDTH)


def _forest(found: Results, rows: Sequence[Estimate]) -> list[ForestRow]:
    made = []
    for row in rows:
        share = found.get("share_accounted_for", agent=row.agent, modality=row.modality, of=row.of)
        of = f"; {share_of_row(share)} of it" if share else ""
        lead = row.of == PICTURES
        style = Style(colour=INK if lead else SUBJECTS[0], lead=lead)
        made.append(ForestRow(_NAMES[row.of], f"{steps_said(row.value, row.low, row.high)}{of}", row, style))
    return made


def _draw(axes: Axes, panel: tuple[Results, list[Estimate]]) -> None:
    found, rows = panel
    ends = [end for row in rows for end in (row.low, row.high, row.value) if end is not None]
    reach = (max(0.0, *ends) - min(0.0, *ends)) or 1.0
    limits = min(0.0, *ends) - 0.06 * reach, max(0.0, *ends) + 0.06 * reach
    pictures = next((row.value for row in rows if row.of == PICTURES), None)
    levels: list[tuple[float, str, Dash]] = [
        (0.0, FAINT, "-"),
        *([(pictures, INK, (0, (4, 3)))] if pictures is not None else []),
    ]
    forest(axes, _forest(found, rows), limits, levels=levels, wide=_WIDE)
    axes.set_xlabel("steps more than with true reports in words")
    first = rows[0]
    title(axes, safe_name(first.agent, _LONGEST), safe_name(f"{spoken(first.modality)}; n = {first.clusters} blocks"))
