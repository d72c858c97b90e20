"""Sentences on conditions: their effects compared with the control, and interactions of crossed conditions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from lockprobe.analysis.condition import ConditionSummary
from lockprobe.analysis.dose_grid import GridSummary
from lockprobe.analysis.effects import Effect, Effects, Interplay
from lockprobe.analysis.modalities import spoken
from lockprobe.formatting import p_value, points, range_said
from lockprobe.prose.subject import Subject
from lockprobe.prose.success import of_trials
from lockprobe.record import PLAIN_WORDS

__all__ = ["effects_said", "grid_said"]

_TWO_BY_TWO = 4
"""Cells of the smallest grid, in which the interaction is the difference of differences."""


def effects_said(found: Effects, conditions: Mapping[tuple[str, str], ConditionSummary]) -> list[str]:
    """The sentences about one agent: every condition against the control, then crossed ones and grids.

    Args:
        found: Its effects.
        conditions: Every agent under every condition -> its numbers.
    """
    name = Subject.of(found.agent, "" if found.modality in PLAIN_WORDS else spoken(found.modality)).first
    share = conditions[found.agent, found.control].success
    said = []
    for words, chosen in (
        ("more often", [one for one in found.effects if one.detectable and one.difference.value > 0]),
        ("less often", [one for one in found.effects if one.detectable and one.difference.value < 0]),
    ):
        if chosen:
            said.append(f"{name} solved the box {words} under {_listed(chosen)}.")
    said.append(f"{name} solved {of_trials(share)} under {found.control}.")
    if hidden := [one for one in found.effects if not one.detectable]:
        said.append(
            f"No difference from {found.control} was detected under {_listed(hidden)}. "
            "This does not show that there is no effect."
        )
    many = [f"comparing {len(found.effects)} conditions with {found.control}"] * (len(found.effects) > 1)
    many += [f"{found.agents} agents"] * (found.agents > 1)
    if many:
        said.append(f"P values and intervals of differences are corrected for {' and for '.join(many)}.")
    return said + [_interplay_said(one) for one in found.interplays] + [grid_said(one) for one in found.grids]


def _listed(effects: Sequence[Effect]) -> str:
    return "; ".join(
        f"{one.condition} ({points(one.difference.value)} points, {points(one.difference.low)} to "
        f"{points(one.difference.high)}; {p_value(one.difference.p_value)})"
        for one in effects
    )


def _interplay_said(one: Interplay) -> str:
    change, crossing = one.change, one.crossing
    many = f", corrected for {one.choices} interactions" if one.choices > 1 else ""
    test = "" if change.p_value is None else f"; {p_value(change.p_value)}{many}"
    size = f"{points(change.value)} points{range_said(change.low, change.high)}{test}"
    if one.detectable:
        return f"The effect of {crossing.second} depends on {crossing.first} (interaction {size})."
    return f"No interaction between {crossing.first} and {crossing.second} was detected ({size})."


def grid_said(one: GridSummary) -> str:
    """Whether the effect of one dose depends on the other, in a sentence."""
    grid, change = one.grid, one.interaction
    first, second = grid.rows.name, grid.columns.name
    under = f" under {grid.rows.rest}" if grid.rows.rest else ""
    if change is None:
        why = "no trial has ended under every combination"
        if not grid.complete:
            why = "some combinations were not played"
        elif len(one.cells) < len(grid.conditions):
            why = "under some combinations no trial has ended, or an intervention changed nothing"
        return f"The interaction between {first} and {second}{under} is not estimated: {why}."
    interval = (
        ""
        if change.low is None or change.high is None
        else f"{_level(one)} interval {points(change.low)} to {points(change.high)}; "
    )
    lines = "" if len(grid.conditions) == _TWO_BY_TWO else f"; linear trends over {len(grid.conditions)} conditions"
    lowest, highest = grid.row_doses[0], grid.row_doses[-1]
    size = f"{points(change.value)} points ({interval}{p_value(change.p_value)}{lines})"
    doses = f"{grid.column_doses[0]:g} to {grid.column_doses[-1]:g}"
    what = f"the effect of {second} ({doses}) at {first} {highest:g} minus that at {first} {lowest:g}"
    if one.detectable:
        return f"The effect of {second} depends on {first}{under}: {what} is {size}."
    return f"No interaction between {first} and {second}{under} was detected: {what} is {size}."


def _level(one: GridSummary) -> str:
    return "95 %" if one.choices == 1 else f"{100 - 5 / one.choices:.3g} %"
