"""Validation messages: pydantic's sentences in plain words, and the checks of a probability and of a choice."""

from __future__ import annotations

import re
from collections.abc import Iterable

from lockprobe.errors import BadValue

__all__ = ["check_choice", "check_probability", "plain"]

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
    """Refuse a value that is not a probability.

    Raises:
        BadValue: If it is not from 0 to 1.
    """
    if not 0.0 <= value <= 1.0:
        raise BadValue(what, value, "a number from 0 to 1")


def check_choice(what: str, value: str, known: Iterable[str]) -> None:
    """Refuse a value that is not among the known ones.

    Raises:
        BadValue: If it is not; the message lists them.
    """
    if value not in known:
        raise BadValue(what, value, f"one of {', '.join(known)}")
