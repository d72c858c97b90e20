"""What a class or function says of itself."""

from __future__ import annotations

from inspect import cleandoc


def docstring(thing: object) -> str:
    """The docstring of a class, a function or an object's class; empty without one."""
    return cleandoc(thing.__doc__ or "")


def first_line(thing: object) -> str:
    """The first line of a docstring."""
    return docstring(thing).partition("\n")[0]
