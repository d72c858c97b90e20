"""Sentences on why false reports change success: their content, or the disturbance."""

from __future__ import annotations

from lockprobe.analysis.agent_comparison.paired import BlockMean
from lockprobe.analysis.modalities import spoken
from lockprobe.analysis.proportions import ALPHA
from lockprobe.analysis.why import Why
from lockprobe.formatting import p_value, percent, points, range_said
from lockprobe.prose.subject import Subject
from lockprobe.record import PLAIN_WORDS

__all__ = ["arm_said", "mechanism_said", "why_said"]

_ARMS = {
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


def arm_said(arm: str) -> str:
    """What happens in an arm at the selected steps."""
    return _ARMS[arm]


def mechanism_said(found: Why) -> str:
    """The verdict in one sentence."""
    subject = Subject.of(found.agent, "" if found.modality in PLAIN_WORDS else spoken(found.modality))
    way = "raise" if found.change.value > 0 else "lower"
    of = f"the success of {subject.name}"
    if found.verdict == "says":
        return f"False reports {way} {of} through their content."
    if found.verdict == "disturbs":
        return f"False reports {way} {of} through the disturbance; no effect of their content was detected."
    if found.verdict == "both":
        return f"False reports {way} {of} in two ways: {_two(found)}."
    if found.verdict == "unexplained":
        return f"False reports {way} {of}; neither an effect of their content nor of the disturbance was detected."
    if found.verdict == "no change":
        return f"False reports change {of} by less than {100 * found.margin:.0f} points."
    large = f"a change of {100 * found.margin:.0f} points or more is not excluded"
    return f"Inconclusive: no effect of false reports on {of} was detected, and {large}."


def _two(found: Why) -> str:
    said, disturbs = ("raises" if one.value > 0 else "lowers" for one in (found.says, found.disturbs))
    if said == disturbs:
        return "through their content and through the disturbance"
    return f"their content {said} it, the disturbance {disturbs} it"


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
    corrected = f"P values and intervals of differences are corrected for {found.agents} agents (Bonferroni)."
    return said + _others(found) + [corrected] * (found.agents > 1)


def _others(found: Why) -> list[str]:
    """Other changes of success in the same direction at the same steps, by interval and corrected test."""
    if found.verdict in ("no change", "not detectable"):
        return []
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
