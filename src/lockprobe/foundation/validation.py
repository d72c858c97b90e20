"""Validation: what is read from files, pydantic's sentences in plain words, checks of values."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from functools import cache, partial
from inspect import signature
from math import inf
from numbers import Integral, Real
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Literal, NamedTuple, TypeVar, Union, get_args, get_origin, get_type_hints

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from lockprobe.foundation.errors import BadFile, BadValue, UnknownName, UserMistake

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


class Written(BaseModel):
    """Base of what a user writes into a file."""

    model_config = ConfigDict(frozen=True, extra="forbid")


_Written = TypeVar("_Written", bound=Written)


def validated(kind: type[_Written], given: object, path: Path | None = None) -> _Written:
    """What a user has written, into a file if there is a path.

    Raises:
        UserMistake: If something is wrong, as BadFile if it is of a file: where, what came, what is allowed.
    """
    try:
        return kind.model_validate(given)
    except ValidationError as error:
        first = error.errors()[0]
    where = ".".join(map(str, first["loc"])) or "all"
    mistake = f"{where}: {(said := plain(first['msg']))}"
    if first["type"] == "extra_forbidden" and len(first["loc"]) == 1:
        mistake = f"{where}: {UnknownName('key', where, kind.model_fields)}"
    elif said.startswith("expected "):
        mistake = str(BadValue(where, first["input"], said.removeprefix("expected ")))
    raise UserMistake(mistake) if path is None else BadFile(path, mistake)


class Within(NamedTuple):
    """In the annotation of a field its least and its largest value: ``Annotated[int, Within(1)]``."""

    least: float
    most: float = inf


Share = Annotated[float, Within(0, 1)]
"""A share, or a probability."""

StepNumber = Annotated[int, Within(1)]
"""The number of a step."""


class Checked:
    """A dataclass that refuses a field with another value than its annotation lists, or beyond its bounds."""

    __slots__ = ()

    def __post_init__(self) -> None:
        for name, hint in _hints(self.__class__).items():
            _check(name.rstrip("_"), getattr(self, name), hint)


_hints: Callable[[Any], dict[str, Any]] = cache(partial(get_type_hints, include_extras=True))


def _check(what: str, value: Any, hint: Any) -> None:
    kind, *parts = get_origin(hint), *get_args(hint)
    if kind is Literal:
        check_choice(what, value, parts)
    elif kind is tuple:  # of any length, all of one kind
        for one in value:
            _check(what, one, parts[0])
    elif kind in (Union, UnionType) and value is not None:
        _check(what, value, parts[0])
    elif kind is Annotated and parts[0] is int:
        check_whole(what, value, *parts[1])
    elif kind is Annotated:
        check_number(what, value, *parts[1])


def check_number(what: str, value: float, least: float = 0, most: float = 1) -> None:
    """Refuse a value that is not a number in a range; if none is given, not a probability."""
    if not (isinstance(value, Real) and least <= value <= most):
        raise BadValue(what, value, f"a number from {least} to {most}")


def check_whole(what: str, value: object, least: float, most: float = inf) -> None:
    """Refuse a value that is not a whole number in a range."""
    if not (isinstance(value, Integral) and least <= int(value) <= most):
        raise BadValue(what, value, f"a whole number from {least}" + f" to {most}" * (most < inf))


def check_choice(what: str, value: str, known: Iterable[str]) -> None:
    """Refuse a value that is not among the known ones."""
    if value not in known:
        raise BadValue(what, value, f"one of {', '.join(known)}")


def check_function(what: str, value: Any, takes: int) -> None:
    """Refuse what cannot be called with so many arguments; some classes, as ``float``, do not say what they take."""
    try:
        fits = callable(value) and bool(signature(value).bind(*range(takes)))
    except TypeError:
        fits = False
    except ValueError:
        fits = True
    if not fits:
        raise BadValue(what, value, f"a function of {takes} argument{'s' * (takes > 1)}")
