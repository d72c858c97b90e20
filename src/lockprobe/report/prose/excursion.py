"""Sentences on the effect of one false report."""

from __future__ import annotations

from collections.abc import Mapping

from lockprobe.foundation.formatting import change, corrected, p_value
from lockprobe.report.prose.subject import Subject
from lockprobe.statistics.excursion import SOON, Among, Excursions, Outcome
from lockprobe.statistics.proportions import ALPHA

__all__ = ["AMONG", "OUTCOMES", "excursion_said"]

OUTCOMES: Mapping[Outcome, str] = {
    "repeats": "the next action repeats this one",
    "new": "the next action is new in this state",
    "leaves": "the next action leaves the loop",
    "optimal": "the next action is optimal if every report is believed",
    "soon": f"the box is solved within {SOON} steps",
    "solved": "the box is solved",
}
"""Outcomes, in words."""

AMONG: Mapping[Among, str] = {
    "all": "all reports",
    "false moved": "the joint was blocked, and is reported to have moved",
    "false blocked": "the joint moved, and is reported blocked",
    "in a loop": "in an action loop",
    "elsewhere": "outside action loops",
}
"""Which reports are meant, in words."""


def excursion_said(found: Excursions, subject: Subject) -> str:
    """The effect of one more false report on success, and the effect that the study detects with a power of 80 %.

    Args:
        found: The effects on one agent.
        subject: The agent.
    """
    one = next((one for one in found.estimates if (one.outcome, one.among) == ("solved", "all")), None)
    if one is None:
        why = next((one.reason for one in found.left_out if (one.outcome, one.among) == ("solved", "all")), "no report")
        return f"The effect of one false report on the success of {subject.name} is not estimated: {why}."
    size = f"{change(one.effect, one.low, one.high)}; {p_value(one.p_value)}{corrected((found.agents, 'agents'))}"
    if one.p_value < ALPHA:
        way = "more" if one.effect > 0 else "less"
        found_said = f"one more false report makes {subject.name} {way} likely to solve the box ({size})"
    else:
        found_said = f"no effect of one more false report on the success of {subject.name} was detected ({size})"
    return (
        f"Above a flip rate of 0, {found_said}. The power to detect an effect of {100 * one.smallest:.0f} points is "
        f"80 % ({one.points} reports in {one.clusters} blocks)."
    )
