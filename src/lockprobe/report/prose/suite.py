"""The conclusion from the scores of a suite, in a sentence."""

from __future__ import annotations

from collections.abc import Sequence

from lockprobe.foundation.formatting import bracketed, first_three, share
from lockprobe.statistics.suite.scores import SuiteScore

__all__ = ["ranks_said", "suite_said"]


def suite_said(entries: Sequence[tuple[str, SuiteScore]], *, stops: bool = False) -> str:
    """Who is the most competent, or that it is not decided, and how false reports change the first one's competence.

    Args:
        entries: Names and scores, the highest competence first.
        stops: Whether its studies stop when they are decided. Its intervals are of a fixed number of trials, so nothing
            is concluded from them then.
    """
    if not entries or (competence := entries[0][1].competence) is None:
        return "No agent has finished trials at every level yet."
    name, first = entries[0]
    size = f"{share(competence.value, competence.low, competence.high)}, where 0 % is chance and 100 % solves every box"
    if stops:
        highest = (
            f"{name} has a competence of" if len(entries) == 1 else f"The highest measured competence is {name}'s:"
        )
        where = "Whether false reports change success, the reports of its studies say, which hold at every look."
        return f"{highest} {size}. {where}"
    if first.ranks is None:
        return f"{name} has a competence of {size}. {_change_said(first)}".rstrip()
    tied = [other for other, one in entries if one.competence is not None and one.competence.value == competence.value]
    said = (
        f"{first_three(tied)} {'has' if len(tied) == 1 else 'have'} the highest competence of {first.together} agents"
    )
    possible = sum(one.ranks is not None and one.ranks[0] == 1 for _, one in entries)
    undecided = f"; the tests do not decide which of {possible} of them is the best" if possible > 1 else ""
    return f"{said}: {size}{undecided}. {_change_said(first) if len(tied) == 1 else ''}".rstrip()


def _change_said(first: SuiteScore) -> str:
    """How false reports change its competence."""
    moved = first.robustness
    if moved is None:
        opened = any(level.told.count or level.misled.count for level in first.levels)
        return (
            "" if opened or not first.levels else "It opened no box, so false reports could not lower its competence."
        )
    change = bracketed(moved.value, moved.low, moved.high)
    if not (moved.low > 0 or moved.high < 0):
        return f"No effect of false reports on its competence was detected ({change} points)."
    return f"False reports {'raise' if moved.value > 0 else 'lower'} its competence ({change} points)."


def ranks_said(one: SuiteScore) -> str:
    """The ranks that are possible; empty without any."""
    if one.ranks is None:
        return ""
    low, high = one.ranks
    return f"{low}" if low == high else f"{low} to {high}"
