"""Validation: what is read from files, pydantic's sentences in plain words, checks of numbers and choices."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import cache
from numbers import Integral, Real
from typing import Annotated, Any, Literal, get_args, get_origin, get_type_hints

from pydantic import ConfigDict, Field

from lockprobe.foundation.errors import BadValue

AS_WRITTEN = ConfigDict(strict=True, extra="forbid")
"""How a class is read from a file that Lockprobe has written: no value is converted, and nothing else stands there."""

Text = Annotated[str, Field(min_length=1, max_length=1000)]
"""A text in such a file."""

_WORDS = (
    (r", (unable to (parse|interpret) .*|got .*|not \d+)$", ""),
    (r" after validation$", ""),
    (r"^Value error, ", ""),
    (r"^(Extra inputs are not permitted|Unexpected keyword argument)$", "no such key"),
    (r"^Field required$", "is missing"),
    (r"^(Input|\w+) should (be|have|match) ", "expected "),
    (r"^it should be ", "expected "),
    (r"\b(a )?valid integer\b", "a whole number"),
    (r"\b(a )?valid number\b", "a number"),
    (r"\b(a )?valid string\b", "a text"),
    (r"\b(a )?valid (list|array|tuple)\b", "a list"),
    (r"\b(a )?valid boolean\b", "true or false"),
    (r"\b(a )?valid (dictionary|mapping|object)\b", "a table"),
    (r"\ba valid ", "a "),
    (r"greater than or equal to ", "at least "),
    (r"less than or equal to ", "at most "),
)
"""Replacements, applied in order."""


def plain(message: str) -> str:
    """A message of pydantic in plain words.

    >>> plain("Input should be a valid integer, unable to parse string as an integer")
    'expected a whole number'
    >>> plain("Input should be greater than or equal to 1")
    'expected at least 1'
    """
    for before, after in _WORDS:
        message = re.sub(before, after, message)
    return message


def check_probability(what: str, value: float) -> None:
    """Refuse a value that is not a probability."""
    if not (isinstance(value, Real) and 0.0 <= value <= 1.0):
        raise BadValue(what, value, "a number from 0 to 1")


def check_whole(what: str, value: object, least: int, most: int | None = None) -> None:
    """Refuse a value that is not a whole number in a range; ``most`` is None where there is no largest one."""
    if not (isinstance(value, Integral) and least <= int(value) and (most is None or int(value) <= most)):
        to = "" if most is None else f" to {most}"
        raise BadValue(what, value, f"a whole number from {least}{to}")


def check_choices(made: Any) -> None:
    """Refuse a field of a dataclass with another value than those that its annotation lists."""
    for name, known in _listed(made.__class__).items():
        check_choice(name.rstrip("_"), getattr(made, name), known)


@cache
def _listed(kind: Any) -> dict[str, tuple[str, ...]]:
    return {name: get_args(hint) for name, hint in get_type_hints(kind).items() if get_origin(hint) is Literal}


def check_choice(what: str, value: str, known: Iterable[str]) -> None:
    """Refuse a value that is not among the known ones."""
    if value not in known:
        raise BadValue(what, value, f"one of {', '.join(known)}")
