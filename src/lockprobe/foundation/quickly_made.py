"""Frozen dataclasses of which a trial makes hundreds."""

from __future__ import annotations

from dataclasses import MISSING, fields
from typing import Any, TypeVar

_C = TypeVar("_C", bound=type[Any])


def quickly_made(made: _C) -> _C:
    """Let a frozen dataclass with slots be made in half the time; nothing else of it changes.

    Python's own looks up how a field is set, and then the field by its name, for each field of each object. Here both
    are looked up once for the class.
    """
    known: dict[str, Any] = {"none": MISSING}
    said, done = ["self", "*"] if fields(made)[0].kw_only else ["self"], []
    for part in fields(made):
        name, anew = part.name, part.default_factory is not MISSING
        known[f"set_{name}"] = getattr(made, name).__set__
        known[f"new_{name}"] = part.default_factory if anew else part.default
        default = "=none" if anew else "" if part.default is MISSING else f"=new_{name}"
        said.append(f"{name}{default}")
        done.append(f"set_{name}(self, " + (f"new_{name}() if {name} is none else {name})" if anew else f"{name})"))
    exec(f"def __init__({', '.join(said)}): {'; '.join(done)}", known)  # noqa: S102 - of names of fields alone
    made.__init__ = known["__init__"]
    return made
