"""Differences in success, a row each: conditions against the control, agent against agent, study against study.

A filled mark is a difference that was detected.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lockprobe.foundation.formatting import bracketed, minus
from lockprobe.foundation.grouping import grouped
from lockprobe.report.figures.compose import sheet
from lockprobe.report.figures.forest import ForestRow, around, forest, height
from lockprobe.report.figures.frame import agent_label, safe_name, title, title_lines
from lockprobe.report.figures.palette import ACCENT, SUBJECTS, Marker, Style
from lockprobe.report.figures.primitives import Interval
from lockprobe.report.figures.settings import FAINT, own_settings
from lockprobe.report.rows import Estimate, Results
from lockprobe.statistics.agent_comparison.across_studies import Side, StudyDifference
from lockprobe.statistics.conditions.axis import FLIPS
from lockprobe.statistics.proportions import ALPHA

SHOWN = 15
"""Differences that one picture of agents or of studies has room for; those of the first pair are always shown."""

_LONGEST, _WHOLE = 38, 46
"""Characters of a name above a bar; the same where there is one panel in a row."""

_WIDEST = 1.5
"""Width of an interval from which on it says nothing and is not drawn; chosen by eye."""


@dataclass(frozen=True, slots=True)
class Panel:
    """Differences around a line at none. An axis without a label has no numbers either.

    ``room`` is the height of the axes, where they stand beside some with more rows.
    """

    rows: Sequence[ForestRow]
    label: str
    title: Sequence[str]
    reach: float
    room: float = 0.0

    @classmethod
    def of(cls, rows: Sequence[ForestRow], *titles: str, label: str = "difference, points") -> Panel:
        """Rows with an axis that holds them all."""
        return cls(rows, label, titles, _reach(rows))


@own_settings()
def panels_sheet(panels: Sequence[Panel], columns: int, note: str = "") -> Figure | None:
    """The panels on one axis, so that they can be compared, each row of them as high as the longest in it."""
    bands = [panels[i : i + columns] for i in range(0, len(panels), columns)]
    heights = [max(height(one.rows) for one in band) for band in bands]
    reach = max((one.reach for one in panels), default=0.0)
    shown = [replace(one, room=room, reach=reach) for band, room in zip(bands, heights, strict=True) for one in band]
    lines = max((len(title_lines(*one.title)) for one in panels), default=0)
    return sheet(shown, _draw, columns=columns, heights=heights, around=around(lines), note=note)


def _reach(rows: Sequence[ForestRow]) -> float:
    """How far an axis around none has to go for these rows, at least 10 points."""
    ends = (end for row in rows for end in (row.found.value, row.found.low, row.found.high))
    return 1.06 * max([0.1, *(abs(end) for end in ends if end is not None)])


def _draw(axes: Axes, panel: Panel) -> None:
    """Rows of differences of shares, on an axis in points."""
    reach = panel.reach
    forest(axes, panel.rows, (-reach, reach), levels=((0.0, FAINT, "-"),), room=panel.room)
    ticks = range(-200, 201, 50 if reach > 0.6 else 25 if reach > 0.25 else 10)
    inside = [tick for tick in ticks if abs(tick) <= 100 * reach]
    names = [minus(f"{tick:+d}") if tick else "0" for tick in inside] if panel.label else []
    axes.set_xticks([tick / 100 for tick in inside], names or [""] * len(inside))
    axes.set_xlabel(panel.label)
    title(axes, *panel.title)


def difference(
    name: str, found: Interval, *, detected: bool, colour: str = SUBJECTS[0], marker: Marker = "o", where: str = ""
) -> ForestRow:
    """A row of a difference; one without an interval that says something has no mark."""
    if found.low is not None and found.high is not None and found.high - found.low > _WIDEST:
        few = f"{where}too few trials to compare"
        return ForestRow(name, few, Estimate(quantity="none"), Style(colour=colour, marker=marker, lead=False))
    said = where + bracketed(found.value, found.low, found.high)
    return ForestRow(name, said, found, Style(colour=colour, marker=marker, lead=detected))


@own_settings()
def side_by_side(found: Results) -> Figure | None:
    """Every two agents on the same boxes: differences in success and, below, in the effect of false reports.

    The agents are those that the study is about, with baselines if there is only one such agent. None if no agents are
    compared.
    """
    pairs = [row for row in found.where("success_difference", axis=FLIPS.name, of="") if row.versus]
    pairs = [row for row in pairs if row.family == pairs[0].family]
    if not pairs:
        return None
    pairs, left = pairs[:SHOWN], len(pairs[SHOWN:])
    more = f"the first {SHOWN} pairs, {left} more in the tables" if left else ""
    rows = [difference(_versus(found, row), row, detected=row.detected) for row in pairs]
    over = "success over all flip rates" if found.several_p else "success"
    panels = [Panel.of(rows, over, more)]
    if changes := [row for pair in pairs for row in _clearest_change(found, pair)]:
        panels.append(Panel.of(changes, "change from the lowest flip rate, at the clearest difference"))
    return panels_sheet(panels, 1)


def _clearest_change(found: Results, pair: Estimate) -> list[ForestRow]:
    """The difference in the effect of false reports at the flip rate where it is clearest; none if not compared."""
    rates = {one.name: one.p for one in found.design.conditions}
    changes = found.where("success_change_difference", **pair.pair, of="")
    changes = [row for row in changes if rates[row.condition] is not None]
    if not changes:
        return []
    clearest = min(changes, key=lambda row: (row.p_value, -abs(row.value or 0.0)))
    tested = found.one("success_change_difference", **pair.pair, of="any flip rate")
    detected = tested.p_value is not None and tested.p_value < ALPHA
    where = f"to {rates[clearest.condition]:g}: "
    return [difference(_versus(found, clearest), clearest, detected=detected, where=where)]


def _versus(found: Results, row: Estimate) -> str:
    names = {(one.agent, one.modality): agent_label(one) for one in found.courses()}
    return f"{names[row.agent, row.modality]}\n\N{MINUS SIGN} {names[row.versus, row.versus_modality]}"


@own_settings()
def by_condition(found: Results) -> Figure | None:
    """Every two agents under each condition that is no flip rate, and the difference in what the condition changes.

    A panel for each pair and quantity, a row for each condition. The agents are chosen as in :func:`side_by_side`. None
    if no agents are compared.
    """
    rates = {one.name: one.p for one in found.design.conditions}
    titles = {
        "success_difference": "difference in success under the condition",
        "success_change_difference": "difference in what the condition changes",
    }
    panels = []
    for quantity, said in titles.items():
        own = [row for row in found.where(quantity, of="", axis="") if row.versus and row.family]
        own = [row for row in own if rates.get(row.condition, 0.0) is None]
        first = own[0].family.partition(",")[0] if own else ""
        pairs = [row for row in own if row.family.partition(",")[0] == first]
        left = len(pairs[SHOWN:])
        more = f"the first {SHOWN}, {left} more in the tables" if left else ""
        compared = grouped(pairs[:SHOWN], lambda row: _versus(found, row))
        rows = {pair: [_under(row) for row in under] for pair, under in compared.items()}
        panels += [Panel.of(under, said, *pair.split("\n"), more) for pair, under in rows.items()]
    return panels_sheet(panels, 1)


def _under(row: Estimate) -> ForestRow:
    return difference(safe_name(row.condition, _LONGEST), row, detected=row.detected)


@own_settings()
def comparison_drawing(found: Sequence[StudyDifference], names: Mapping[Side, str]) -> Figure | None:
    """Agents of several studies: the first pairs one below the other, with one axis for all.

    Args:
        found: The differences; nothing is drawn without any.
        names: What each side is called.
    """
    pairs = pair_rows(found)
    panels = []
    for i, ((first, second), rows) in enumerate(pairs.items(), start=1):
        label = "difference in success, points" if i == len(pairs) else ""
        named = (safe_name(names[second], _WHOLE), f"\N{MINUS SIGN} {safe_name(names[first], _WHOLE)}")
        panels.append(Panel.of(rows, *named, label=label))
    left = len(found) - sum(len(one.rows) for one in panels)
    note = f"{left} more differences are in the tables" if left else ""
    return panels_sheet(panels, 1, note)


def pair_rows(found: Sequence[StudyDifference]) -> dict[tuple[Side, Side], list[ForestRow]]:
    """The rows of each pair, one for every condition, as far as there is room.

    Blue circles are pairs of trials, orange squares are independent samples; filled marks are shown.
    """
    pairs: dict[tuple[Side, Side], list[ForestRow]] = {}
    for one in found:
        colour, marker = (SUBJECTS[0], "o") if one.paired else (ACCENT, "s")
        name = safe_name(one.condition, _WHOLE)
        row = difference(name, one, detected=bool(one.verdict), colour=colour, marker=marker)
        pairs.setdefault((one.first, one.second), []).append(row)
    kept: dict[tuple[Side, Side], list[ForestRow]] = {}
    for pair, rows in pairs.items():
        if kept and sum(map(len, kept.values())) + len(rows) > SHOWN:
            break
        kept[pair] = rows
    return kept
