"""Every two agents on the same boxes: differences in success, and in the effect of false reports."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lockprobe.analysis.axis import FLIPS
from lockprobe.analysis.proportions import ALPHA
from lockprobe.figures.compose import sheet
from lockprobe.figures.forest import ForestRow, differences, height, interval
from lockprobe.figures.frame import agent_label, title
from lockprobe.figures.palette import SUBJECTS
from lockprobe.figures.settings import own_settings
from lockprobe.rows import Estimate, Results

__all__ = ["SHOWN", "side_by_side"]

SHOWN = 15
"""Pairs that one picture has room for."""


@own_settings()
def side_by_side(found: Results) -> Figure | None:
    """Differences in success and, below, in the effect of false reports; None if no agents are compared."""
    rows, moved = _difference_rows(found), _change_rows(found)
    if not rows:
        return None
    below = [(_draw_changes, height(moved))] if moved else []
    draws, heights = zip((_draw_differences, height(rows)), *below, strict=True)
    return sheet([found], *draws, heights=heights)


def _drawn(found: Results) -> tuple[list[Estimate], int]:
    """The differences that are drawn, and how many there is no room for.

    They are of agents that the study is about; with baselines if there is only one such agent.
    """
    rows = [row for row in found.where("success_difference", axis=FLIPS.name, of="") if row.versus]
    rows = [row for row in rows if row.family == rows[0].family]
    return rows[:SHOWN], len(rows[SHOWN:])


def _difference_rows(found: Results) -> list[ForestRow]:
    """Differences in success over all flip rates, a row for each pair."""
    rows, _ = _drawn(found)
    return [_row(found, row, detected=row.detected) for row in rows]


def _change_rows(found: Results) -> list[ForestRow]:
    """Differences in the effect of false reports on success, at the flip rate with the clearest difference."""
    rates = {one.name: one.p for one in found.design.conditions}
    rows = []
    for one in _drawn(found)[0]:
        pair = one.pair
        changes = found.where("success_change_difference", **pair, of="")
        if changes:
            clearest = min(changes, key=lambda row: (row.p_value, -abs(row.value or 0.0)))
            tested = found.one("success_change_difference", **pair, of="any flip rate")
            where = f"to {rates[clearest.condition]:g}: "
            rows.append(_row(found, clearest, detected=_rejects(tested), where=where))
    return rows


def _rejects(row: Estimate) -> bool:
    return row.p_value is not None and row.p_value < ALPHA


def _draw_differences(axes: Axes, found: Results) -> None:
    """Differences in success over all flip rates."""
    differences(axes, _difference_rows(found))
    _, left = _drawn(found)
    title(axes, "success over all flip rates", f"the first {SHOWN} pairs, {left} more in the tables" if left else "")


def _draw_changes(axes: Axes, found: Results) -> None:
    """Differences between agents in the effect of false reports on success."""
    differences(axes, _change_rows(found))
    title(axes, "change from the lowest flip rate, at the clearest difference")


def _row(found: Results, row: Estimate, *, detected: bool, where: str = "") -> ForestRow:
    names = {(one.agent, one.modality): agent_label(one) for one in found.courses()}
    return ForestRow(
        name=f"{names[row.agent, row.modality]}\n\N{MINUS SIGN} {names[row.versus, row.versus_modality]}",
        said=where + interval(row.value, row.low, row.high),
        value=row.value,
        low=row.low,
        high=row.high,
        colour=SUBJECTS[0],
        face=SUBJECTS[0] if detected else "white",
    )
