"""Checks whether a decision can be executed and recorded. Anyone can write an agent, so every decision is checked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from reprlib import repr as shortened

from pydantic import TypeAdapter, ValidationError

from lockprobe.foundation.errors import ReplyFault
from lockprobe.foundation.redaction import without_keys
from lockprobe.trial.record import Decision, Task

_record: TypeAdapter[Decision] = TypeAdapter(Decision)


def usable(decision: Decision, task: Task) -> Decision:
    """A decision without API keys in its texts and without claims where nobody asked.

    Raises:
        ReplyFault: If it cannot be executed or recorded.
    """
    if (why := _why_unusable(decision, task.joints)) is not None:
        raise ReplyFault(why, tuple(map(str, getattr(decision, "replies", None) or ())))
    if decision.hypothesis or decision.replies:
        decision = replace(
            decision,
            hypothesis=without_keys(decision.hypothesis),
            replies=tuple(map(without_keys, decision.replies)),
            served=without_keys(decision.served),
        )
    if not task.assessment:
        decision = replace(decision, claimed=None, claim_probability=None)
    return decision


def _why_unusable(decision: object, labels: Sequence[str]) -> str | None:
    if not isinstance(decision, Decision):  # of an object the type alone, because its words may hold anything
        plain = decision is None or isinstance(decision, str | int | float)
        found = shortened(decision) if plain else f"an object of type {type(decision).__name__}"
        return f"decide returned {found}; return Decision(joint=…)"
    if decision.joint not in labels:
        return f"{decision.joint!r} is no joint; the joints of this trial are {', '.join(labels)}"
    if decision.claimed not in ("moved", "blocked", None):
        return f"claimed {decision.claimed!r} is none of moved, blocked, None"
    chances, claimed = decision.probabilities, decision.claim_probability
    if chances is not None and not (isinstance(chances, tuple | list) and len(chances) == len(labels)):
        return f"its probabilities are not one number for each of {len(labels)} joints"
    numbers = (*(chances or ()), 0 if claimed is None else claimed)
    if not all(isinstance(number, float | int) and 0 <= number <= 1 for number in numbers):
        return "a probability lies outside 0 to 1"
    added = (decision.hypothesis, decision.replies, decision.usage, decision.served, decision.tidied)
    return None if added == ("", (), None, "", ()) else _why_unwritable(decision)


def _why_unwritable(decision: Decision) -> str | None:
    """Why what models add to a decision cannot be written: it goes to the record and back, which takes longer."""
    try:
        _record.validate_json(_record.dump_json(decision, exclude_defaults=True, warnings=False), strict=True)
    except ValidationError as error:
        first = error.errors()[0]
        return f"its {'.'.join(map(str, first['loc']))} cannot be written ({first['msg']})"
    except (TypeError, ValueError) as error:
        return f"its text cannot be written ({error})"
    return None
