"""Sentences on a robot: how often it broke the rules of the box."""

from __future__ import annotations

from lockprobe.statistics.rules import RuleBreaks


def broken_said(found: RuleBreaks | None) -> str:
    """How many attempts broke the rules of the box, in few words; empty if none did."""
    if found is None or not found.against:
        return ""
    return f"{found.against} of {found.attempts} attempts broke the rules of the box."
