"""Sentences on what one report did, from forks of recorded trials."""

from __future__ import annotations

from collections.abc import Sequence

from lockprobe.analysis.branch import BranchEffect
from lockprobe.analysis.proportions import ALPHA
from lockprobe.formatting import minus, p_value, percent, points, range_said

__all__ = ["branch_said", "found_said", "place_said", "size_said", "value_said"]

_PLACES = {
    "onset": "the report that completes its first loop",
    "first-lie": "its first false report",
    "before-onset": "a report drawn from step 3 up to its first loop",
}

_TOLD = {
    "lie": "one inverted report",
    "retracted": "one inverted report that is corrected at once",
    "confirmed": "one true report that is given again as its correction",
    "remark": "one irrelevant sentence",
    "withheld": "one missing report",
    "tremble": "another joint attempted next than the chosen one",
    "random": "a joint drawn at random attempted next",
}


def place_said(where: str) -> str:
    """Where trials were forked, in words."""
    return _PLACES.get(where, f"the report of step {where}")


def _arm_said(arm: str) -> str:
    kind, _, joint = arm.partition("=")
    return f"joint {joint} attempted next" if kind == "force" else _TOLD.get(arm, arm)


def size_said(one: BranchEffect) -> str:
    """A change of a share in points, with its interval."""
    return f"{points(one.change.value)}{range_said(one.change.low, one.change.high)}"


def value_said(outcome: str, change: float) -> str:
    """A change alone: points, steps, or a distance from 0 to 1."""
    if outcome == "steps":
        return minus(f"{change:+.1f}")
    return f"{change:.2f}" if outcome == "choice" else points(change)


def found_said(effects: Sequence[BranchEffect]) -> list[str]:
    """A sentence for every effect on success that is detectable; one sentence where none is."""
    found = [branch_said(one) for one in effects if _found(one)]
    if found or not effects:
        return found
    return [branch_said(effects[0]) if len(effects) == 1 else "No effect on success is detectable."]


def branch_said(one: BranchEffect) -> str:
    """What an arm does to success at one place, in a sentence."""
    size = f"{points(one.change.value)} points{range_said(one.change.low, one.change.high)}"
    does = ("raises" if one.change.value > 0 else "lowers") if _found(one) else "has no detectable effect on"
    later = "; later reports are true" if one.truthful else ""
    return (
        f"At {place_said(one.where)}, {_arm_said(one.arm)} {does} the success of {one.agent} ({one.condition}): "
        f"{percent(one.after_truth)} after a true report, {size}; {p_value(one.change.p_value)}, "
        f"{one.change.blocks} trials, {one.forks} forks{later}."
    )


def _found(one: BranchEffect) -> bool:
    low, high, p = one.change.low, one.change.high, one.change.p_value
    return p is not None and p < ALPHA and low is not None and high is not None and (low > 0 or high < 0)
