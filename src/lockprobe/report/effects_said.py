"""What each condition did to an agent, in plain words, with no more than the numbers bear."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from lockprobe.analysis.condition import ConditionSummary
from lockprobe.analysis.effects import Effect, Effects, Interplay
from lockprobe.analysis.modalities import spoken
from lockprobe.analysis.speaking import begun, called, of_trials, p_said, points_said
from lockprobe.record import UNNAMED
from lockprobe.report.grids import grid_said

__all__ = ["effects_said"]


def effects_said(found: Effects, conditions: Mapping[tuple[str, str], ConditionSummary]) -> list[str]:
    """The sentences about one agent: every condition against the control, then crossed ones and grids.

    Args:
        found: Its effects.
        conditions: Every agent under every condition -> its numbers.
    """
    name = called(found.agent, "" if found.modality in UNNAMED else spoken(found.modality))
    share = conditions[found.agent, found.control].success
    said = []
    for words, chosen in (
        ("more often", [one for one in found.effects if one.detectable and one.difference.value > 0]),
        ("less often", [one for one in found.effects if one.detectable and one.difference.value < 0]),
    ):
        if chosen:
            said.append(begun(f"{name} solved the box {words} under {_listed(chosen)}."))
    said.append(begun(f"{name} solved {of_trials(share)} under {found.control}."))
    if hidden := [one for one in found.effects if not one.detectable]:
        said.append(
            f"No difference from {found.control} is detectable under {_listed(hidden)}. That is no evidence of none."
        )
    if len(found.effects) > 1:
        many = f"P values and intervals of differences are corrected for comparing {len(found.effects)} conditions"
        said.append(f"{many} with {found.control}.")
    return said + [_interplay_said(one) for one in found.alone] + [grid_said(one) for one in found.grids]


def _listed(effects: Sequence[Effect]) -> str:
    return "; ".join(
        f"{one.condition} ({points_said(one.difference.value)} points, {points_said(one.difference.low)} to "
        f"{points_said(one.difference.high)}; {p_said(one.difference.p_value)})"
        for one in effects
    )


def _interplay_said(one: Interplay) -> str:
    change, crossing = one.change, one.crossing
    test = "" if change.p_value is None else f"; {p_said(change.p_value)}, not corrected"
    ends = (
        ""
        if change.low is None or change.high is None
        else (f", 95 % interval {points_said(change.low)} to {points_said(change.high)}")
    )
    size = f"{points_said(change.value)} points{ends}{test}"
    if one.detectable:
        return f"What {crossing.second} does changes where {crossing.first} acts too ({size})."
    return f"That {crossing.second} does something else where {crossing.first} acts too is not detectable ({size})."
