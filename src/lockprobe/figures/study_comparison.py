"""Differences between agents of several studies: a panel for each pair, a row for each condition."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from lockprobe.analysis.agent_comparison.across_studies import Side, StudyDifference
from lockprobe.figures.forest import ForestRow, differences, height, interval, reach_of
from lockprobe.figures.frame import FAINT, SMALL, safe_name, shortened, title
from lockprobe.figures.palette import ACCENT, SUBJECTS
from lockprobe.figures.settings import own_settings

__all__ = ["SHOWN", "comparison_drawing", "pair_rows"]

SHOWN = 15
"""Differences that one picture has room for; those of the first pair are always shown."""

_WIDTH = 3.6
"""Inches."""

_LONGEST = 46
"""Characters of a name above a bar."""

_BETWEEN = 0.1
"""Inches less where no axis is named below a pair."""

_TITLE = 0.25
"""Inches more for the second line of a title."""


def pair_rows(found: Sequence[StudyDifference]) -> dict[tuple[Side, Side], list[ForestRow]]:
    """The rows of each pair, one for every condition, as far as there is room.

    Blue circles are pairs of trials, orange squares are independent samples; filled marks are shown.
    """
    pairs: dict[tuple[Side, Side], list[ForestRow]] = {}
    for one in found:
        pairs.setdefault((one.first, one.second), []).append(_row(one))
    kept: dict[tuple[Side, Side], list[ForestRow]] = {}
    for pair, rows in pairs.items():
        if kept and sum(map(len, kept.values())) + len(rows) > SHOWN:
            break
        kept[pair] = rows
    return kept


def _row(one: StudyDifference) -> ForestRow:
    colour, marker = (SUBJECTS[0], "o") if one.paired else (ACCENT, "s")
    return ForestRow(
        name=safe_name(shortened(one.condition, _LONGEST)),
        said=interval(one.value, one.low, one.high),
        value=one.value,
        low=one.low,
        high=one.high,
        colour=colour,
        marker=marker,
        face=colour if one.verdict else "white",
    )


@own_settings()
def comparison_drawing(found: Sequence[StudyDifference], names: Mapping[Side, str]) -> Figure:
    """The first pairs one below the other, each as a forest around none.

    Args:
        found: The differences, at least one.
        names: What each side is called.
    """
    pairs = pair_rows(found)
    every = [row for rows in pairs.values() for row in rows]
    left = len(found) - len(every)
    heights = [height(rows) + _TITLE - _BETWEEN * (i < len(pairs) - 1) for i, rows in enumerate(pairs.values())]
    rows_each = [len(rows) for rows in pairs.values()]
    figure = Figure(figsize=(_WIDTH, sum(heights)), layout=ConstrainedLayoutEngine(w_pad=0.06))
    panels = figure.subplots(len(pairs), 1, squeeze=False, height_ratios=rows_each)[:, 0]
    for axes, ((first, second), rows) in zip(panels, pairs.items(), strict=True):
        last = axes is panels[-1]
        differences(axes, rows, "difference in success, points" if last else "", reach=reach_of(every))
        if not last:
            axes.set_xticklabels([])
        lines = (names[second], f"\N{MINUS SIGN} {names[first]}")
        title(axes, *(safe_name(shortened(line, _LONGEST)) for line in lines))
    if left:
        figure.supxlabel(f"{left} more differences are in the tables", fontsize=SMALL, color=FAINT)
    return figure
