"""How often a plant broke the rules of their box, in few words."""

from __future__ import annotations

from collections.abc import Iterable

from lockprobe.boxes.box import Lockbox
from lockprobe.statistics.rules import against_rules
from lockprobe.trial.record import Trial


def broken_said(trials: Iterable[Trial], *boxes: Lockbox) -> str:
    """How many attempts broke the rules of the box, also in trials that broke later; empty if none did."""
    judged = [one.against for trial in trials for one in against_rules(trial, *boxes)]
    return f"{sum(judged)} of {len(judged)} attempts broke the rules of the box." if any(judged) else ""
