"""Sentences on a robot: how often it broke the rules of the box."""

from __future__ import annotations

from lockprobe.statistics.rules import RuleBreaks


def broken_said(found: RuleBreaks | None) -> str:
    """How many attempts broke the rules of the box, in few words; empty if none did."""
    if found is None or not found.against:
        return ""
    return f"{found.against} of {found.attempts} attempts broke the rules of the box."


def not_judged(found: RuleBreaks | None) -> str:
    """Why no claim of the paper is judged: attempts broke the rules of the box; empty if none did."""
    broken = broken_said(found)
    return f"No claim of the paper is judged: {broken}" if broken else ""
