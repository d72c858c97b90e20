"""Sentences on the bridge from pictures to flips: what misreadings account for, as false reports in words."""

from __future__ import annotations

from lockprobe.foundation.formatting import bracketed, p_value, percent
from lockprobe.statistics.bridge.arms import PICTURES, WORDS
from lockprobe.statistics.bridge.bridge import Bridge
from lockprobe.statistics.bridge.share import Share
from lockprobe.statistics.conditions.modalities import spoken

__all__ = ["ARMS_SAID", "bridge_said", "numbers_said", "others_said", "share_said", "steps_said"]

ARMS_SAID = {
    WORDS: "true reports in words",
    PICTURES: "pictures",
    "replayed": "words; the misreadings of the pictures are told, one by one",
    "shuffled": "words; as many reports are false, at random steps",
    "profile": "words; reports are false at the rates of each joint and direction",
    "symmetric": "words; reports are false at the total rate of misreadings",
}
"""What an agent is told in an arm."""

_OTHERS = {
    "shuffled": "As many false reports at random steps",
    "profile": "flips at the rates of each joint and direction",
    "symmetric": "flips at the total rate",
}


def share_said(share: Share) -> str:
    """A share with its interval: ``97 % [85, 110]``."""
    if share.low is None or share.high is None:
        return f"{percent(share.value)} (interval not bounded)"
    return f"{percent(share.value)} [{100 * share.low:.0f}, {100 * share.high:.0f}]".replace("-", "\N{MINUS SIGN}")


def steps_said(value: float | None, low: float | None, high: float | None) -> str:
    """A difference in steps with its interval."""
    return bracketed(value, low, high, "{:+.1f}", 1)


def bridge_said(found: Bridge) -> str:
    """The verdict in one sentence."""
    agent, verdict = found.agent, found.verdict()
    pictures = spoken(found.modality)
    if verdict == "nothing said":
        return f"Not known: {agent} never said what its actions did, so its misreadings are not known."
    if verdict == "no difference":
        return (
            f"Inconclusive: it is not shown that {agent} takes more or fewer steps with {pictures} than with words, so "
            "there is no difference that misreadings could account for."
        )
    way = "more" if found.total.value > 0 else "fewer"
    takes = f"{agent} takes {way} steps with {pictures} than with words"
    if verdict == "nothing misread":
        return f"{takes}, and it misread no outcome: misreadings account for none of the difference."
    share = found.arm("replayed").share
    size = share_said(share) if share is not None else ""
    told = "told as false reports in words, its misreadings"
    said = {
        "all": f"{told} account for the difference: {size} of it",
        "part": f"{told} account for a part of the difference: {size} of it",
        "none": f"{told} account for little or none of the difference: {size} of it",
        "more": f"{told} do more than pictures do: {size} of the difference",
        "opposite": f"{told} change the number of steps the other way: {size} of the difference",
        "not decided": f"which part of the difference its misreadings account for is not decided: {size} of it",
    }
    return f"{takes}; {said[verdict]}."


def numbers_said(found: Bridge) -> str:
    """The numbers under the verdict: steps, success, and how much was misread."""
    words, pictures, misread, total = found.arm(WORDS), found.arm(PICTURES), found.misread, found.total
    hidden, invented = misread.count("moved"), misread.count("blocked")
    said = f"It misread {misread.misread} of {misread.claims} outcomes"
    if misread.misread:
        kinds = f"{hidden[0]} of {hidden[1]} moves were hidden, {invented[0]} of {invented[1]} failures taken for moves"
        said = f"{said} ({percent(misread.misread / misread.claims, 1)}: {kinds})"
    if not misread.claims:
        said = "It said nothing of its actions"
    return (
        f"Mean steps: {words.steps:.1f} in words, {pictures.steps:.1f} in pictures (difference "
        f"{steps_said(total.value, total.low, total.high)}, {p_value(total.p_value)}, {total.blocks} blocks). Solved: "
        f"{percent(words.success.value)} and {percent(pictures.success.value)}. {said}."
    )


def others_said(found: Bridge) -> str:
    """What false reports give that repeat the misreadings less exactly; empty unless pictures change steps."""
    known = [
        f"{said} give {share_said(one.share)}"
        for arm, said in _OTHERS.items()
        for one in found.arms
        if one.arm == arm and one.share is not None
    ]
    return f"{'; '.join(known)} of the difference." if known and found.misread.misread else ""
