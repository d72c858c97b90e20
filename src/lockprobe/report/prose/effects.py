"""Sentences on conditions: their effects compared with the control, and interactions of crossed conditions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from lockprobe.foundation.formatting import change, corrected, p_value, points
from lockprobe.report.prose.subject import Subject
from lockprobe.report.prose.success import of_trials
from lockprobe.statistics.conditions.condition import ConditionSummary
from lockprobe.statistics.conditions.dose_grid import GridSummary
from lockprobe.statistics.conditions.effects import Effect, Effects, Interplay

__all__ = ["effects_said", "grid_said"]

_TWO_BY_TWO = 4
"""Cells of the smallest grid, in which the interaction is the difference of differences."""


def effects_said(found: Effects, conditions: Mapping[tuple[str, str], ConditionSummary]) -> list[str]:
    """The sentences about one agent: every condition against the control, then crossed ones and grids.

    Args:
        found: Its effects.
        conditions: Every agent under every condition -> its numbers.
    """
    name = Subject.seeing(found.agent, found.modality).first
    share = conditions[found.agent, found.control].success
    shown = [one for one in found.effects if one.detectable]
    said = [
        f"{name} solved the box {words} often under {_listed(chosen)}."
        for words, chosen in (
            ("more", [one for one in shown if one.difference.value > 0]),
            ("less", [one for one in shown if one.difference.value < 0]),
        )
        if chosen
    ]
    said.append(f"{name} solved {of_trials(share)} under {found.control}.")
    if hidden := [one for one in found.effects if not one.detectable]:
        said.append(
            f"No difference from {found.control} was detected for {name} under {_listed(hidden)}. "
            "This does not show that there is no effect."
        )
    many = [f"comparing {len(found.effects)} conditions with {found.control}"] * (len(found.effects) > 1)
    many += [f"{found.agents} agents"] * (found.agents > 1)
    if many:
        said.append(f"P values and intervals of differences are corrected for {' and for '.join(many)}.")
    return said + [_interplay_said(one) for one in found.interplays] + [grid_said(one) for one in found.grids]


def _listed(effects: Sequence[Effect]) -> str:
    return "; ".join(
        f"{one.condition} ({points(gap.value)} points, {points(gap.low)} to {points(gap.high)}; {p_value(gap.p_value)})"
        for one in effects
        for gap in [one.difference]
    )


def _interplay_said(one: Interplay) -> str:
    found, crossing = one.change, one.crossing
    many = corrected((one.choices, "interactions"))
    test = "" if found.p_value is None else f"; {p_value(found.p_value)}{many}"
    size = f"{change(found.value, found.low, found.high)}{test}"
    if one.detectable:
        return f"The effect of {crossing.second} depends on {crossing.first} (interaction {size})."
    return f"No interaction between {crossing.first} and {crossing.second} was detected ({size})."


def grid_said(one: GridSummary) -> str:
    """Whether the effect of one dose depends on the other, in a sentence."""
    grid, found = one.grid, one.interaction
    first, second = grid.rows.name, grid.columns.name
    under = f" under {grid.rows.rest}" if grid.rows.rest else ""
    if found is None:
        why = "no trial has ended under every combination"
        if not grid.complete:
            why = "some combinations were not played"
        elif len(one.cells) < len(grid.conditions):
            why = "under some combinations no trial has ended, or an intervention changed nothing"
        return f"The interaction between {first} and {second}{under} is not estimated: {why}."
    level = "95 %" if one.choices == 1 else f"{100 - 5 / one.choices:.3g} %"
    known = found.low is not None and found.high is not None
    interval = f"{level} interval {points(found.low or 0.0)} to {points(found.high or 0.0)}; " if known else ""
    lines = "" if len(grid.conditions) == _TWO_BY_TWO else f"; linear trends over {len(grid.conditions)} conditions"
    lowest, highest = grid.row_doses[0], grid.row_doses[-1]
    what = (
        f"the effect of {second} ({grid.column_doses[0]:g} to {grid.column_doses[-1]:g}) at {first} {highest:g} minus "
        f"that at {first} {lowest:g} is {points(found.value)} points ({interval}{p_value(found.p_value)}{lines})"
    )
    if one.detectable:
        return f"The effect of {second} depends on {first}{under}: {what}."
    return f"No interaction between {first} and {second}{under} was detected: {what}."
