"""Results put together from their parts: what cannot be made is left out, and the results say so."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from pydantic import ValidationError

from lockprobe.report.details import AuditedSentences, AuditResult, LeftOutResult
from lockprobe.report.schema import Results
from lockprobe.sections import section

__all__ = ["Part", "assembled"]

Part = tuple[str, Callable[[], Any]]
"""What a reader would call a part of the results, and the function that makes it."""

_WITHOUT: Mapping[str, Any] = {
    "agents": {},
    "audit": AuditResult(seed=0, worlds={}, rates=[], many_agents=AuditedSentences(worlds={}, rates=[])),
    "box": None,
    "left_out": LeftOutResult(
        errors=0,
        replayed_on_request=0,
        replaced_after_an_error=0,
        repeated=0,
        unfinished_lines=0,
        not_asked_for=0,
        foreign=0,
    ),
    "plants": {},
}
"""What stands in the place of fields that have no default and are no list."""


def assembled(parts: Mapping[str, Part], **kept: Any) -> Results:
    """The results of a study.

    Args:
        parts: Field -> what makes it. A field that cannot be made is empty.
        kept: Fields that are known already.
    """
    made = {name: section(title, make, partial(_without, name)) for name, (title, make) in parts.items()}
    try:
        return Results(**made, **kept)
    except ValidationError as error:
        wrong = error.errors(include_url=False)
    for name in parts.keys() & {str(one["loc"][0]) for one in wrong}:
        why = "; ".join(str(one["msg"]) for one in wrong if one["loc"][0] == name)
        made[name] = section(parts[name][0], partial(_refuse, why), partial(_without, name))
    return Results(**made, **kept)


def _refuse(why: str) -> Any:
    raise ValueError(why)


def _without(name: str) -> Any:
    """What stands in the place of a field."""
    field = Results.model_fields[name]
    if not field.is_required():
        return field.get_default(call_default_factory=True)
    return _WITHOUT.get(name, [])
