"""What parts of results have in common: they are frozen, described, and written without defaults."""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field


def _finite(value: object) -> object:
    """None for what is not a number, as JSON has it."""
    return None if isinstance(value, float) and not math.isfinite(value) else value


Number = Annotated[float | None, BeforeValidator(_finite)]
Probability = Annotated[float | None, Field(ge=0, le=1), BeforeValidator(_finite)]


class Part(BaseModel):
    """A part of the results. What has its default is not written."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    def plain(self) -> dict[str, Any]:
        """The part as JSON holds it, without columns that have their default."""
        return self.model_dump(mode="json", exclude_defaults=True)
