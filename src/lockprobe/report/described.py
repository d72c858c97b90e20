"""Parts of the results whose described fields are published, the types of their numbers, and how they are filled."""

from __future__ import annotations

import math
from dataclasses import fields
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, GetJsonSchemaHandler
from pydantic.json_schema import SkipJsonSchema
from pydantic_core import CoreSchema

__all__ = ["Change", "Counted", "DescribedResult", "FiniteNumber", "Share", "filled"]


def _finite(value: object) -> object:
    """None for what is not a number, as JSON has it."""
    return None if isinstance(value, float) and not math.isfinite(value) else value


FiniteNumber = Annotated[float | SkipJsonSchema[int] | None, BeforeValidator(_finite)]
Share = Annotated[float | None, Field(ge=0, le=1), BeforeValidator(_finite)]
Counted = Annotated[int, Field(ge=0)]
Change = Annotated[float, Field(ge=-2, le=2)]


class DescribedResult(BaseModel):
    """A part of the results whose described fields are published."""

    model_config = ConfigDict(extra="allow", frozen=True, from_attributes=True)

    @classmethod
    def __get_pydantic_json_schema__(cls, core_schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """The schema of the fields that have a description, and of those that are such parts."""
        schema = handler(core_schema)
        found = handler.resolve_ref_schema(schema)
        published = {
            name
            for name, about in cls.model_fields.items()
            if about.description
            or (isinstance(about.annotation, type) and issubclass(about.annotation, DescribedResult))
        }
        found["properties"] = {name: found["properties"][name] for name in found["properties"] if name in published}
        found["required"] = [name for name in found.get("required", ()) if name in published]
        return schema


_Result = TypeVar("_Result")


def filled(kind: type[_Result], *sources: object, **named: object) -> _Result:
    """A result, each of its fields from the first source that has an attribute of the same name.

    Args:
        kind: A dataclass or a pydantic model.
        sources: Values of the analysis.
        named: Fields that have another name there, or another value.
    """
    names = kind.model_fields if issubclass(kind, BaseModel) else [field.name for field in fields(kind)]  # type: ignore[arg-type]
    for name in names:
        for source in sources:
            if name not in named and hasattr(source, name):
                named[name] = getattr(source, name)
    return kind(**named)
