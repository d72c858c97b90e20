"""The conclusion from the scores of a suite, in a sentence."""

from __future__ import annotations

from collections.abc import Sequence

from lockprobe.analysis.suite_scores import SuiteScore
from lockprobe.formatting import bracketed, share

__all__ = ["suite_said"]


def suite_said(entries: Sequence[tuple[str, SuiteScore]]) -> str:
    """The competence of the first agent and how false reports change it; of several agents the first is the best.

    Args:
        entries: Names and scores, the highest competence first.
    """
    if not entries or (competence := entries[0][1].competence) is None:
        return "No agent has finished trials at every level yet."
    name, best = entries[0]
    size = share(competence.value, competence.low, competence.high)
    head = (
        f"{name} has the highest competence of {len(entries)} agents"
        if len(entries) > 1
        else f"{name} has a competence of"
    )
    said = f"{head}{':' if len(entries) > 1 else ''} {size}, where 0 % is chance and 100 % solves every box"
    if (moved := best.robustness) is None:
        return f"{said}."
    change = bracketed(moved.value, moved.low, moved.high)
    shown = moved.low > 0 or moved.high < 0
    if not shown:
        return f"{said}. No effect of false reports on it was detected ({change} points)."
    return f"{said}. False reports {'raise' if moved.value > 0 else 'lower'} it ({change} points)."
