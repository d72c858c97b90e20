"""Sentences on why false reports change success: their content, or the disturbance."""

from __future__ import annotations

from lockprobe.analysis.agent_comparison.paired import BlockMean
from lockprobe.analysis.proportions import ALPHA
from lockprobe.analysis.why import Why
from lockprobe.formatting import p_value, percent, points, range_said
from lockprobe.prose.subject import Subject

__all__ = ["ARMS", "mechanism_said", "why_said"]

ARMS = {
    "truth": "every report is true",
    "lie": "the report is inverted",
    "retracted": "the report is inverted, and corrected at once",
    "confirmed": "the report is true, and repeated as a correction",
    "remark": "an irrelevant sentence follows the true report",
    "lie + remark": "the report is inverted, and an irrelevant sentence follows",
    "withheld": "there is no report",
    "tremble": "another joint than the chosen one is attempted, with a true report",
    "nudge": "a sentence names every action loop; reports are true",
    "lie in loops": "the report is inverted where the attempt continues an action loop",
    "self-yoked": "as many reports are inverted as under lie in loops, at random steps",
}
"""What happens in an arm at the selected steps."""


def mechanism_said(found: Why) -> str:
    """The verdict in one sentence."""
    way = "raise" if found.change.value > 0 else "lower"
    of = f"the success of {Subject.seeing(found.agent, found.modality).name}"
    if found.verdict == "says":
        return f"False reports {way} {of} through their content."
    if found.verdict == "disturbs":
        return f"False reports {way} {of} through the disturbance; no effect of their content was detected."
    if found.verdict == "both":
        said, disturbs = ("raises" if one.value > 0 else "lowers" for one in (found.says, found.disturbs))
        ways = f"their content {said} it, the disturbance {disturbs} it"
        if said == disturbs:
            ways = "through their content and through the disturbance"
        return f"False reports {way} {of} in two ways: {ways}."
    if found.verdict == "unexplained":
        return f"False reports {way} {of}; neither an effect of their content nor of the disturbance was detected."
    if found.verdict == "no change":
        return f"False reports change {of} by less than {100 * found.margin:.0f} points."
    large = f"a change of {100 * found.margin:.0f} points or more is not excluded"
    return f"Inconclusive: no effect of false reports on {of} was detected, and {large}."


def why_said(found: Why) -> list[str]:
    """The verdict, its numbers, and how many blocks an inconclusive study would need."""
    success = {one.arm: one.success for one in found.arms}
    numbers = (
        f"{percent(success['truth'].value)} of trials were solved with true reports, "
        f"{percent(success['lie'].value)} with reports inverted at a rate of {found.p:g}: {_size(found.change)}. "
        f"With false reports that are corrected at once it is {percent(success['retracted'].value)}. So the effect of "
        f"the disturbance is {_size(found.disturbs)}, and the effect of the content {_size(found.says)}."
    )
    said = [mechanism_said(found), numbers]
    if found.verdict in ("no change", "not detectable"):
        said.append(
            "Two one-sided tests of a change of "
            f"{100 * found.margin:.0f} points or more in either direction give {p_value(found.equivalence)}."
        )
    if found.verdict in ("unexplained", "not detectable"):
        said.append(
            f"About {found.needed} blocks are needed to detect a change of {100 * found.margin:.0f} points with a "
            f"power of 80 %; this study has {found.change.blocks}."
        )
    if found.verdict not in ("no change", "not detectable"):
        said += _others(found)
    if found.agents > 1:
        said.append(f"P values and intervals of differences are corrected for {found.agents} agents (Bonferroni).")
    return said


def _others(found: Why) -> list[str]:
    """Other changes of success in the same direction at the same steps, by interval and corrected test."""
    same = [
        f"{one.arm} {_size(change)}"
        for one in found.arms
        if one.arm in ("confirmed", "remark", "withheld", "tremble")
        and (change := one.change) is not None
        and change.clear
        and change.p_value is not None
        and change.p_value < ALPHA
        and (change.value > 0) == (found.change.value > 0)
    ]
    way = "raise" if found.change.value > 0 else "lower"
    return [f"Other interventions at the same steps also {way} success: {'; '.join(same)}."] if same else []


def _size(found: BlockMean) -> str:
    return f"{points(found.value)} points ({range_said(found.low, found.high)[2:]}; {p_value(found.p_value)})"
