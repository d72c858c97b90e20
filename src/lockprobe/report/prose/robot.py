"""Sentences on a robot: how often its own verdicts were wrong, and how often it broke the rules of the box."""

from __future__ import annotations

from lockprobe.foundation.formatting import percent, range_of
from lockprobe.statistics.robot import Verdicts
from lockprobe.statistics.rules import RuleBreaks

__all__ = ["not_judged", "rules_said", "verdicts_said"]


def verdicts_said(found: Verdicts) -> str:
    """How often a robot was wrong about the outcome of its attempts."""
    wrong = found.wrong
    if not wrong.n:
        return f"The robot could not determine the outcome of any of {found.attempts} attempts."
    failed = f"; it could not decide at {found.failed} more" if found.failed else ""
    moved, blocked = found.moved_for_blocked, found.blocked_for_moved
    kinds = f": {moved} took a blocked joint for moved, {blocked} a moved joint for blocked" if wrong.count else ""
    return (
        f"The robot's own verdict, from force and distance, was wrong at {wrong.count} of {wrong.n} attempts "
        f"({percent(wrong.value, 1)}, 95 % interval {range_of(wrong.low, wrong.high, 1)}){kinds}{failed}. "
        "Agents are not told this verdict."
    )


def rules_said(found: RuleBreaks) -> str:
    """How many attempts broke the rules of the box, and how; empty if none did."""
    if not found.against:
        return ""
    kinds = [
        f"{count} {what}"
        for count, what in (
            (found.missed, f"of {found.free} at free joints moved nothing"),
            (found.forced, f"of {found.attempts - found.free} at locked joints moved them"),
            (found.others, "moved another joint"),
        )
        if count
    ]
    share = percent(found.against / found.attempts, 1)
    return (
        f"{found.against} of {found.attempts} attempts ({share}) broke the rules of the box: {', '.join(kinds)}. "
        "The plant did that, not the agent. Success, steps and loops count these attempts as they were; success by "
        "chance and the shortest plan are those of a box without them."
    )


def not_judged(found: RuleBreaks | None) -> str:
    """Why no agent is judged: attempts broke the rules of the box; empty if none did."""
    if found is None or not found.against:
        return ""
    return f"No agent is judged: {found.against} of {found.attempts} attempts broke the rules of the box."
