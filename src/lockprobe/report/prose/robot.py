"""How often a plant broke the rules of their box, in few words."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from lockprobe.statistics.rules import Judged


def broken_said(judged: Iterable[Sequence[Judged]]) -> str:
    """How many attempts of trials broke the rules of the box, also in trials that broke later; empty if none did."""
    against = [one.against for trial in judged for one in trial]
    return f"{sum(against)} of {len(against)} attempts broke the rules of the box." if any(against) else ""
