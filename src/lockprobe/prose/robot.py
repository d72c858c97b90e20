"""The sentence on a robot's own verdicts: how often they were wrong."""

from __future__ import annotations

from lockprobe.analysis.robot import Verdicts
from lockprobe.formatting import percent

__all__ = ["verdicts_said"]


def verdicts_said(found: Verdicts) -> str:
    """How often a robot was wrong about the outcome of its attempts."""
    wrong = found.wrong
    if not wrong.n:
        return f"The robot could not determine the outcome of any of {found.attempts} attempts."
    failed = f"; it could not decide at {found.failed} more" if found.failed else ""
    kinds = (
        f": {found.moved_for_blocked} took a blocked joint for moved, {found.blocked_for_moved} a moved joint for "
        "blocked"
        if wrong.count
        else ""
    )
    return (
        f"The robot's own verdict, from force and distance, was wrong at {wrong.count} of {wrong.n} attempts "
        f"({percent(wrong.value, 1)}, 95 % interval {100 * wrong.low:.1f} to {percent(wrong.high, 1)}){kinds}{failed}. "
        "Agents are not told this verdict, and no number below depends on it."
    )
