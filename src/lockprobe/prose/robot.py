"""The sentence on a robot's own verdicts: how often it was wrong about what it had done."""

from __future__ import annotations

from lockprobe.analysis.robot import Verdicts
from lockprobe.formatting import percent

__all__ = ["verdicts_said"]


def verdicts_said(found: Verdicts) -> str:
    """How often a robot was wrong about what it had done."""
    wrong = found.wrong
    if not wrong.n:
        return f"The robot could tell nothing at any of {found.attempts} attempts."
    failed = f"; at {found.failed} more it could not tell" if found.failed else ""
    kinds = (
        f", {found.moved_for_blocked} of them took a blocked joint for moved, {found.blocked_for_moved} a moved one "
        "for blocked"
        if wrong.count
        else ""
    )
    return (
        f"The robot's own verdict, from force and way, was wrong at {wrong.count} of {wrong.n} attempts "
        f"({percent(wrong.value, 1)}, 95 % interval {100 * wrong.low:.1f} to {percent(wrong.high, 1)}){kinds}{failed}. "
        "Agents are not told it, and no number below rests on it."
    )
