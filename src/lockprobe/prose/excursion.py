"""Sentences on what one false report changes."""

from __future__ import annotations

from collections.abc import Sequence

from lockprobe.analysis.excursion import SOON, Among, Excursion, Outcome
from lockprobe.analysis.proportions import ALPHA
from lockprobe.formatting import p_value, points, range_said
from lockprobe.prose.subject import Subject

__all__ = ["among_said", "excursion_said", "outcome_said"]

_OUTCOMES: dict[Outcome, str] = {
    "repeats": "the next action repeats this one",
    "new": "the next action is new in this state",
    "leaves": "the next action leaves the loop",
    "optimal": "the next action is optimal for one who believes every report",
    "soon": f"the box is solved within {SOON} steps",
    "solved": "the box is solved",
}

_AMONG: dict[Among, str] = {
    "all": "all reports",
    "false moved": "the joint was blocked, and is reported to have moved",
    "false blocked": "the joint moved, and is reported blocked",
    "in a loop": "in an action loop",
    "elsewhere": "outside action loops",
}


def outcome_said(outcome: Outcome) -> str:
    """What is changed, in words."""
    return _OUTCOMES[outcome]


def among_said(among: Among) -> str:
    """Which reports are meant, in words."""
    return _AMONG[among]


def excursion_said(found: Sequence[Excursion], subject: Subject) -> str:
    """What one more lie among lies does to success, and how small an effect the study could have seen.

    Args:
        found: The effects on one agent.
        subject: The agent.
    """
    one = next((one for one in found if (one.outcome, one.among) == ("solved", "all")), None)
    if one is None:
        return f"Too few trials of {subject.name} differ to estimate what one false report does to success."
    size = f"{points(one.effect)} points{range_said(one.low, one.high)}; {p_value(one.p_value)}"
    seen = f"An effect of {100 * one.smallest:.0f} points would have been found with a power of 80 %"
    of = f"{one.points} reports in {one.clusters} blocks"
    if one.p_value < ALPHA:
        way = "more" if one.effect > 0 else "less"
        return f"One more false report makes {subject.name} {way} likely to solve the box ({size}). {seen} ({of})."
    does = f"whether {subject.name} {subject.form('solves', 'solve')} the box"
    return f"That one more false report changes {does} is not detectable ({size}). {seen} ({of})."
