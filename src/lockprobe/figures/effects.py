"""Every condition against the control: differences in success, a row each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lockprobe.figures.compose import sheet
from lockprobe.figures.forest import ForestRow, differences, height, interval, reach_of
from lockprobe.figures.frame import safe_name, shortened, title
from lockprobe.figures.palette import ACCENT, SUBJECTS, Marker
from lockprobe.figures.settings import own_settings
from lockprobe.prose.subject import Subject
from lockprobe.record import PLAIN_WORDS
from lockprobe.rows import Estimate, Results

__all__ = ["effects"]

_LONGEST = 38
"""Characters of a name above a bar."""


@dataclass(frozen=True, slots=True)
class _Panel:
    """One agent: its conditions against the control, and crossings of two interventions that stand in no grid."""

    modality: str
    effects: Sequence[Estimate]
    crossings: Sequence[Estimate]

    @property
    def rows(self) -> list[ForestRow]:
        """A row for each of them."""
        compared = [_row(one, one.condition, SUBJECTS[0]) for one in self.effects]
        return compared + [_row(one, one.of, ACCENT, "s") for one in self.crossings]


@own_settings()
def effects(found: Results) -> Figure | None:
    """A panel for each agent that has conditions to compare."""
    own: dict[tuple[str, str], list[Estimate]] = {}
    for row in found.against_control():
        own.setdefault((row.agent, row.control), []).append(row)
    shown = {one.name: one.modality for one in found.design.conditions}
    panels = [
        _Panel(shown[control], rows, found.where("success_interaction", agent=agent, modality=shown[control], axis=""))
        for (agent, control), rows in own.items()
    ]
    if not panels:
        return None
    reach = max(reach_of(one.rows) for one in panels)  # one axis, so that agents can be compared
    return sheet(panels, partial(_draw, reach=reach), heights=[height(max((one.rows for one in panels), key=len))])


def _row(found: Estimate, name: str, colour: str, marker: Marker = "o") -> ForestRow:
    return ForestRow(
        name=_name(name),
        said=interval(found.value or 0.0, found.low, found.high),
        value=found.value,
        low=found.low,
        high=found.high,
        colour=colour,
        marker=marker,
        face=colour if found.detected else "white",
    )


def _draw(axes: Axes, panel: _Panel, reach: float) -> None:
    """Differences in success from the control, in points, on an axis that ends at ``reach`` on both sides."""
    last, sizes = panel.effects[-1], sorted({one.n or 0 for one in panel.effects})
    differences(axes, panel.rows, f"success minus that under {_name(last.control)}, points", reach=reach)
    shown = "" if panel.modality in PLAIN_WORDS else f" ({panel.modality})"
    pairs = f"{sizes[0]} to {sizes[-1]}" if len(sizes) > 1 else f"{sizes[0]}"
    title(axes, _name(Subject.of(last.agent).name + shown), f"n = {pairs} pairs of trials; filled: detected")


def _name(name: str) -> str:
    return safe_name(shortened(name, _LONGEST))
