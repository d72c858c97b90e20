"""Error messages for files of settings or texts: what came, and what is allowed."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator
from typing import get_args

from pydantic import BaseModel, ValidationError

from lockprobe.foundation.errors import BadValue, UnknownName

_LONGEST = 80
"""The most characters printed of a wrong value."""


def check_visible(text: str) -> str:
    """The text, for a field of a model.

    Raises:
        ValueError: If it holds an invisible control character; line breaks may stay.
    """
    for character in text:
        if unicodedata.category(character) in ("Cc", "Cs") and character not in "\n\t":
            raise ValueError(f"holds the control character U+{ord(character):04X}")
    return text


def first_error(error: ValidationError, model: type[BaseModel]) -> str:
    """The first mistake that pydantic found in what should have been a ``model``."""
    first = error.errors()[0]
    where, kind, came = ".".join(map(str, first["loc"])) or "all", first["type"], first["input"]
    if kind == "extra_forbidden":
        *above, name = first["loc"]
        known = _model_at(model, above).model_fields
        return f"{where}: {UnknownName('key', str(name), known)}"
    if kind == "missing":
        return f"{where}: is missing"
    if kind == "value_error":
        return f"{where}: {first['ctx']['error']}"
    came = came[:_LONGEST] + "…" if isinstance(came, str) and len(came) > _LONGEST else came
    return str(BadValue(where, came, _expected(first["msg"])))


def _expected(message: str) -> str:
    """What is allowed, from pydantic's sentence."""
    message = re.sub(r"^\w+ should (be|have|match) (a valid )?", "", message)
    return re.sub(r"( after validation)?, (not \d+|unable to parse .*|got .*)$", "", message)


def _model_at(model: type[BaseModel], place: list[int | str]) -> type[BaseModel]:
    for name in place:
        if name in model.model_fields:
            model = next(_models(model.model_fields[str(name)].annotation), model)
    return model


def _models(annotation: object) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for inner in get_args(annotation):
        yield from _models(inner)
