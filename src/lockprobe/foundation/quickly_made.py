"""Frozen dataclasses of which a trial makes hundreds."""

from __future__ import annotations

from dataclasses import MISSING, fields
from typing import Any, TypeVar

_C = TypeVar("_C", bound=type[Any])


def quickly_made(made: _C) -> _C:
    """Let a frozen dataclass with slots be made in half the time; nothing else of it changes.

    Python's own looks up how to set a field, and then the field by its name, for each field of each object. Here both
    are looked up once for the class.
    """
    known: dict[str, Any] = {"_none": MISSING}
    said, body = [], []
    for part in fields(made):
        name, value = part.name, part.name
        known[f"_set_{name}"] = getattr(made, name).__set__
        if part.default_factory is not MISSING:
            known[f"_new_{name}"] = part.default_factory
            default, value = "=_none", f"_new_{name}() if {name} is _none else {name}"
        elif part.default is not MISSING:
            known[f"_default_{name}"] = part.default
            default = f"=_default_{name}"
        else:
            default = ""
        said.append(f"{name}{default}")
        body.append(f"    _set_{name}(self, {value})")
    keywords = "*, " if fields(made)[0].kw_only else ""
    source = [f"def __init__(self, {keywords}{', '.join(said)}):", *body]
    exec("\n".join(source), known)  # noqa: S102 - as dataclasses do: names of fields, and nothing else
    known["__init__"].__qualname__ = f"{made.__qualname__}.__init__"
    known["__init__"].__annotations__ = made.__init__.__annotations__
    made.__init__ = known["__init__"]
    return made
