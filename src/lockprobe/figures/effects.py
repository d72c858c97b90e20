"""Every condition against the control: differences in success, a row each."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes

from lockprobe.analysis.effects import Effects
from lockprobe.figures.forest import ForestRow, differences, interval
from lockprobe.figures.frame import safe_name, shortened, title
from lockprobe.figures.palette import ACCENT, SUBJECTS
from lockprobe.record import PLAIN_WORDS

__all__ = ["draw_effects", "effect_rows"]

_LONGEST = 38
"""Characters of a name above a bar."""


def effect_rows(found: Effects) -> list[ForestRow]:
    """A row for each condition, and one for each crossing of two interventions that stands in no grid."""
    rows = [
        ForestRow(
            name=_name(one.condition),
            said=interval(one.difference.value, one.difference.low, one.difference.high),
            value=one.difference.value,
            low=one.difference.low,
            high=one.difference.high,
            colour=SUBJECTS[0],
            face=SUBJECTS[0] if one.detectable else "white",
        )
        for one in found.effects
    ]
    crossed = [
        ForestRow(
            name=_name(f"{one.crossing.first} \N{MULTIPLICATION SIGN} {one.crossing.second}"),
            said=interval(one.change.value, one.change.low, one.change.high),
            value=one.change.value,
            low=one.change.low,
            high=one.change.high,
            colour=ACCENT,
            marker="s",
            face=ACCENT if one.detectable else "white",
        )
        for one in found.interplays
    ]
    return rows + crossed


def draw_effects(axes: Axes, found: Effects) -> None:
    """Differences in success from the control, in points."""
    rows = effect_rows(found)
    differences(axes, rows, f"success minus that under {_name(found.control)}, points")
    shown = "" if found.modality in PLAIN_WORDS else f" ({found.modality})"
    title(axes, _name(found.agent + shown), f"n = {_sizes(found)}; filled: detected")


def _sizes(found: Effects) -> str:
    sizes: Sequence[int] = sorted({one.difference.first.n for one in found.effects})
    return f"{sizes[0]} to {sizes[-1]} pairs of trials" if len(sizes) > 1 else f"{sizes[0]} pairs of trials"


def _name(name: str) -> str:
    return safe_name(shortened(name, _LONGEST))
