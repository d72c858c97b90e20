"""Checks whether a decision can be executed and recorded. Anyone can write an agent, so every decision is checked."""

from __future__ import annotations

from collections.abc import Sequence
from reprlib import repr as shortened

from lockprobe.trial.record import Decision


def why_unusable(decision: Decision, labels: Sequence[str]) -> str | None:
    """The reason why a decision cannot be executed and recorded; None if it can.

    ``labels`` are those of the joints, in the order in which the agent knows them.
    """
    if not isinstance(decision, Decision):
        return f"decide returned {_said(decision)}; return Decision(joint=…)"
    if decision.joint not in labels:
        return f"{decision.joint!r} is no joint; the joints of this trial are {', '.join(labels)}"
    if decision.claimed not in ("moved", "blocked", None):
        return f"claimed {decision.claimed!r} is none of moved, blocked, None"
    return _why_out_of_range(decision) or _why_unwritable(decision)


def _said(found: object) -> str:
    """What was returned, with its type; of an object the type alone, because its words may hold anything."""
    if found is None:
        return "None"
    kind = type(found).__name__
    return f"{shortened(found)} ({kind})" if isinstance(found, str | int | float) else f"an object of type {kind}"


def _why_out_of_range(decision: Decision) -> str | None:
    """The number of a decision that is out of range; None if all are in range."""
    numbers = decision.probabilities or ()
    if decision.claim_probability:
        numbers = (*numbers, decision.claim_probability)
    for number in numbers:
        if not (isinstance(number, (float, int)) and 0 <= number <= 1):
            return "a probability lies outside 0 to 1"
    return None


def _why_unwritable(decision: Decision) -> str | None:
    """Why the texts of a decision cannot be written; None if they can."""
    try:
        "".join((decision.hypothesis, decision.served, *decision.replies)).encode("utf-8")
    except (UnicodeEncodeError, TypeError) as error:
        return f"its text cannot be written ({error})"
    return None
