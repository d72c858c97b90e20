"""Makes and changes values of frozen dataclasses quickly, where thousands are made a second.

A frozen dataclass sets every field by a call that goes around its own refusal, its keywords pass through a dictionary,
and ``dataclasses.replace`` asks for every field anew what it is. Here a function is written for each class, as
:mod:`dataclasses` does it. The value has an open class of the same slots until its fields are set.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import MISSING, Field, fields
from typing import Any, ParamSpec, Protocol, TypeVar

__all__ = ["quick", "quick_replace"]

_P = ParamSpec("_P")
_Made = TypeVar("_Made")

_WRITTEN = """
def outside({known}):
    def make({arguments}):
        made = _open()
        {filled}
        made.__class__ = _kind
        return made
    return make
"""


class _Replace(Protocol[_Made]):
    """A function of a value and of fields that have other values."""

    def __call__(self, value: _Made, /, **changes: Any) -> _Made: ...


def quick(kind: Callable[_P, _Made]) -> Callable[_P, _Made]:
    """A function that takes what a dataclass takes, and makes an equal value in a fifth of the time.

    >>> from lockprobe.foundation.storage.jsonl import State
    >>> quick(State)(1, 2, size=3, tail=b"") == State(1, 2, size=3, tail=b"")
    True

    Args:
        kind: A frozen dataclass with slots. Its ``__init__`` and ``__post_init__`` are not called.
    """
    known, arguments, filled = dict[str, Any](), list[str](), list[str]()
    for field in _fields(kind):
        name = field.name
        default, value = "", name
        if field.default_factory is not MISSING:
            known[f"_new_{name}"], default = field.default_factory, "=_missing"
            value = f"_new_{name}() if {name} is _missing else {name}"
        elif field.default is not MISSING:
            known[f"_usual_{name}"], default = field.default, f"=_usual_{name}"
        arguments += ["*"] * (field.kw_only and "*" not in arguments) + [name + default]
        filled.append(f"made.{name} = {value}")
    make: Callable[_P, _Made] = _written(kind, known, arguments, filled)
    return make


def quick_replace(kind: type[_Made]) -> _Replace[_Made]:
    """What :func:`dataclasses.replace` does with values of a dataclass, in a fifth of the time.

    >>> from lockprobe.foundation.storage.jsonl import State
    >>> quick_replace(State)(State(1, 2, 3, b""), size=4)
    State(device=1, inode=2, size=4, tail=b'')

    Args:
        kind: As for :func:`quick`.
    """
    names = [field.name for field in _fields(kind)]
    filled = [f"made.{name} = _value.{name} if {name} is _missing else {name}" for name in names]
    replace: _Replace[_Made] = _written(kind, {}, ["_value", "/", "*", *(f"{name}=_missing" for name in names)], filled)
    return replace


def _fields(kind: Any) -> tuple[Field[Any], ...]:
    return fields(kind)


def _written(kind: Any, known: dict[str, Any], arguments: list[str], filled: list[str]) -> Any:
    """The function with these arguments that fills the fields of a new value."""
    slots = {"__slots__": [field.name for field in _fields(kind)]}
    known = {"_kind": kind, "_missing": MISSING, "_open": type("_Open", (), slots), **known}
    found: dict[str, Any] = {}
    lines = {"known": ", ".join(known), "arguments": ", ".join(arguments), "filled": "\n        ".join(filled)}
    exec(_WRITTEN.format(**lines), found)  # noqa: S102
    return found["outside"](**known)
