"""Checks whether a decision can be executed and recorded. Anyone can write an agent, so every decision is checked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from reprlib import repr as shortened

from pydantic import TypeAdapter, ValidationError

from lockprobe.foundation.errors import ReplyFault
from lockprobe.foundation.redaction import without_keys
from lockprobe.trial.record import Decision, Task
from lockprobe.trial.trial_json import faults_of

_record: TypeAdapter[Decision] = TypeAdapter(Decision)


def usable(decision: Decision, task: Task) -> Decision:
    """A decision without API keys in its texts and without claims where nobody asked."""
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
    try:
        for what, got, expected in faults_of(decision, labels):
            return f"its {what}: got {shortened(got)}, expected {expected}"
        added = (decision.hypothesis, decision.replies, decision.usage, decision.served, decision.tidied)
        if added != ("", (), None, "", ()):  # what models add goes to the record and back, which takes longer
            _record.validate_json(_record.dump_json(decision, exclude_defaults=True, warnings=False), strict=True)
    except ValidationError as error:
        first = error.errors()[0]
        return f"its {'.'.join(map(str, first['loc']))} cannot be written ({first['msg']})"
    except (TypeError, ValueError) as error:
        return f"it cannot be written ({error})"
    return None
