"""Sentences on why false reports change success: what they say, or that they disturb."""

from __future__ import annotations

from lockprobe.analysis.agent_comparison.paired import BlockMean
from lockprobe.analysis.modalities import spoken
from lockprobe.analysis.proportions import ALPHA
from lockprobe.analysis.why import Why
from lockprobe.formatting import p_value, percent, points, range_said
from lockprobe.prose.subject import Subject
from lockprobe.record import UNNAMED

__all__ = ["arm_said", "mechanism_said", "why_said"]

_ARMS = {
    "truth": "every report is true",
    "lie": "the report is inverted",
    "retracted": "the report is inverted, and corrected at once",
    "confirmed": "the report is true, and given again as its correction",
    "remark": "an irrelevant sentence follows the true report",
    "lie + remark": "the report is inverted, and an irrelevant sentence follows",
    "withheld": "there is no report",
    "tremble": "another joint than the chosen one is attempted, and truly reported",
    "nudge": "a sentence names every action loop; reports are true",
    "lie in loops": "the report is inverted where the attempt continues an action loop",
    "self-yoked": "as many reports are inverted as under lie in loops, at random steps",
}


def arm_said(arm: str) -> str:
    """What happens in an arm at the steps that are hit."""
    return _ARMS[arm]


def mechanism_said(found: Why) -> str:
    """The verdict in one sentence."""
    subject = Subject.of(found.agent, "" if found.modality in UNNAMED else spoken(found.modality))
    way = "raise" if found.change.value > 0 else "lower"
    of = f"the success of {subject.name}"
    if found.verdict == "says":
        return f"False reports {way} {of} because of what they say."
    if found.verdict == "disturbs":
        return f"False reports {way} {of} because they disturb, not because of what they say."
    if found.verdict == "both":
        return f"False reports {way} {of} for two reasons: {_two(found)}."
    if found.verdict == "unexplained":
        return f"False reports {way} {of}; neither what they say nor that they disturb is detectable as the reason."
    if found.verdict == "no change":
        return f"False reports do not change {of} by {100 * found.margin:.0f} points or more."
    return f"Neither a change by false reports in {of} is detectable, nor that there is none."


def _two(found: Why) -> str:
    said, disturbs = ("raises" if one.value > 0 else "lowers" for one in (found.says, found.disturbs))
    if said == disturbs:
        return "what they say, and that they disturb"
    return f"what they say {said} it, that they disturb {disturbs} it"


def why_said(found: Why) -> list[str]:
    """The verdict, the numbers behind it, and how many blocks would have decided what is open."""
    success = {one.arm: one.success for one in found.arms}
    numbers = (
        f"{percent(success['truth'].value)} of trials were solved under true reports, "
        f"{percent(success['lie'].value)} where reports were inverted at a rate of {found.p:g}: {_size(found.change)}. "
        f"With lies that are taken back at once it is {percent(success['retracted'].value)}. So the disturbance alone "
        f"does {_size(found.disturbs)}, and what lies say {_size(found.says)}."
    )
    said = [mechanism_said(found), numbers]
    if found.verdict in ("no change", "not detectable"):
        said.append(
            "Two one-sided tests of a change of "
            f"{100 * found.margin:.0f} points or more either way give {p_value(found.equivalence)}."
        )
    if found.verdict in ("unexplained", "not detectable"):
        said.append(
            f"With about {found.needed} blocks a test would find a change of {100 * found.margin:.0f} points with a "
            f"power of 80 %; there are {found.change.blocks}."
        )
    return said + _others(found)


def _others(found: Why) -> list[str]:
    """What else changes success in the same direction at the same steps, shown by interval and corrected test."""
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
    return [f"Other changes at the same steps also {way} success: {'; '.join(same)}."] if same else []


def _size(found: BlockMean) -> str:
    return f"{points(found.value)} points ({range_said(found.low, found.high)[2:]}; {p_value(found.p_value)})"
