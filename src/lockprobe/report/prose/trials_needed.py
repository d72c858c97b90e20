"""How many trials would decide what a study leaves open: those that make an interval narrow."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import ceil
from statistics import NormalDist

from lockprobe.report.prose.first_screen import NARROW
from lockprobe.report.prose.subject import Subject, subject_of
from lockprobe.statistics.conditions.axis import FLIPS
from lockprobe.statistics.contrast import Effects
from lockprobe.statistics.inference.difference import DifferenceAt
from lockprobe.statistics.proportions import ALPHA, proportion
from lockprobe.statistics.summary import StudySummary


def flips_needed(summary: StudySummary, *, named: bool = False) -> str:
    """How many trials at each dose would decide what is open; empty where nothing is, or nothing can be tested.

    Args:
        summary: Agents over a dose.
        named: Whether the dose is named, as sentences on other changes stand beside this one.
    """
    over = f" over {'the ' * (summary.axis.name == FLIPS.name)}{summary.axis.name}" if named else ""
    hidden = [
        (subject_of(agent) if len(summary.subjects) > 1 else None, over, one.difference, one.choices * one.agents)
        for agent in summary.subjects
        if (one := agent.contrast) and not one.detectable and not agent.blind
    ]
    axis = summary.axis
    dose = axis.name if axis.name == FLIPS.name else f"dose of {axis.name}"
    return _needed(hidden, f"per {dose}{f' ({axis.options})' if axis.options else ''}")


def _needed(differences: Iterable[tuple[Subject | None, str, DifferenceAt, int]], where: str) -> str:
    """How many trials make the widest interval as narrow as :data:`NARROW`, from an estimate to an upper bound.

    Args:
        differences: Whose change it is (None if it is the only one), what changes it, the difference, and the number
            of differences for which its interval is corrected, those of the agents that are judged together included.
        where: Where so many trials are needed.
    """
    found = [
        (needed[::-1], one.first.n, who, what)
        for who, what, one, choices in differences
        if one.first.n and (needed := _trials_for_narrow(one, choices)) and needed[1] > one.first.n
    ]
    if not found:
        return ""
    (most, few), there, who, what = max(found, key=lambda one: one[:2])
    ends = dict.fromkeys(_rounded(max(count, there + 1)) for count in (few, most))
    return (
        f"Estimating the change{f' of {who.name}' if who else ''}{what} to ±{100 * NARROW:.0f} points takes about "
        f"{' to '.join(map(str, ends))} trials {where}; "
        f"{who.form('it has', 'they have') if who else 'this study has'} {there}."
    )


def _trials_for_narrow(found: DifferenceAt, choices: int) -> tuple[int, int] | None:
    """Trials that narrow an interval to :data:`NARROW` either way, estimated and at most; None if it cannot be said.

    The variance of a pair is at most the share of pairs that differ. Few trials may all happen to go alike, so this
    share has an upper bound too. Of people the width of their interval shrinks with the root of trials.
    """
    if found.pairs is not None:
        differ, n = found.pairs.only_first + found.pairs.only_second, found.pairs.n
        z = NormalDist().inv_cdf(1 - ALPHA / 2 / choices)
        few, most = (ceil(share * (z / NARROW) ** 2) for share in ((differ + 1) / (n + 2), proportion(differ, n).high))
        return min(few, most), most
    if found.low <= -1 or found.high >= 1:
        return None
    needed = ceil(found.first.n * ((found.high - found.low) / 2 / NARROW) ** 2)
    return needed, needed


def _rounded(count: int) -> int:
    """Two digits, upwards.

    >>> _rounded(97), _rounded(1234)
    (97, 1300)
    """
    unit = int(10.0 ** max(len(str(count)) - 2, 0))
    return -(-count // unit) * unit


def effects_needed(found: Sequence[Effects]) -> str:
    """How many trials under each condition would decide what is open; empty where nothing is."""
    several = len({own.agent for own in found}) > 1
    hidden = [
        (
            Subject.of(own.agent) if several else None,
            f" under {one.condition}",
            one.difference,
            len(own.effects) * own.agents,
        )
        for own in found
        for one in own.effects
        if not one.detectable
    ]
    return _needed(hidden, "per condition")
