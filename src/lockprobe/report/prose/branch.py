"""Sentences on what one report did, from forks of recorded trials."""

from __future__ import annotations

from collections.abc import Sequence

from lockprobe.foundation.formatting import change, minus, p_value, percent, points, range_said
from lockprobe.statistics.branch import BranchEffect
from lockprobe.statistics.proportions import ALPHA

_PLACES = {
    "onset": "the report that completes its first loop",
    "first-lie": "its first false report",
    "before-onset": "a random report from step 3 to its first loop",
}

_TOLD = {
    "lie": "one inverted report",
    "truth-truth": "one true report that is repeated as a correction",
    "lie-truth": "one inverted report that the truth corrects at once",
    "truth-lie": "one true report that a lie corrects at once",
    "lie-lie": "one inverted report that is repeated as a correction",
    "remark": "one irrelevant sentence",
    "withheld": "one missing report",
    "tremble": "a next attempt at another joint than the chosen one",
    "random": "a next attempt at a random joint",
}


def place_said(where: str) -> str:
    """Where trials were forked, in words."""
    return _PLACES.get(where, f"the report of step {where}")


def size_said(one: BranchEffect) -> str:
    """A change of a share in points, with its interval."""
    return f"{points(one.change.value)}{range_said(one.change.low, one.change.high)}"


def value_said(outcome: str, value: float) -> str:
    """A change alone: points, steps, or a distance from 0 to 1."""
    if outcome == "steps":
        return minus(f"{value:+.1f}")
    return f"{value:.2f}" if outcome == "choice" else points(value)


def found_said(effects: Sequence[BranchEffect]) -> list[str]:
    """A sentence for every detected effect on success; one sentence where there is none."""
    found = [branch_said(one) for one in effects if _found(one)]
    if found or not effects:
        return found
    none = "No effect on success was detected after correction for the number of effects."
    return [branch_said(effects[0]) if len(effects) == 1 else none]


def branch_said(one: BranchEffect) -> str:
    """The effect of an arm on success at one place, in a sentence."""
    later = "; later reports are true" if one.truthful else ""
    kind, _, joint = one.arm.partition("=")
    arm = f"a next attempt at joint {joint}" if kind == "force" else _TOLD.get(one.arm, one.arm)
    on, where = f"the success of {one.agent} ({one.condition})", place_said(one.where)
    said = f"No effect of {arm} at {where} on {on} was detected"
    if _found(one):
        said = f"At {where}, {arm} {'raises' if one.change.value > 0 else 'lowers'} {on}"
    many = f" (corrected for {one.agents} agents)" if one.agents > 1 else ""
    return (
        f"{said}: {percent(one.after_truth)} after a true report, "
        f"{change(one.change.value, one.change.low, one.change.high)}; {p_value(one.change.p_value)}{many}, "
        f"{one.change.blocks} trials, {one.forks} forks{later}."
    )


def _found(one: BranchEffect) -> bool:
    low, high, p = one.change.low, one.change.high, one.change.p_value
    return p is not None and p < ALPHA and low is not None and high is not None and (low > 0 or high < 0)
