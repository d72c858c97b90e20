"""What is known of models: what they accept, what they can see, what they cost. Facts are data (``models.toml``)."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, fields
from fnmatch import fnmatchcase
from functools import cache
from pathlib import Path
from typing import Any, Literal

__all__ = ["ModelFacts", "Price", "facts_of"]

Schema = Literal["strict", "loose", "none"]
"""How the form of a reply can be asked for: as a schema that is enforced, as one that need not be, or in words only."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Price:
    """What a provider asks, in US dollars per million tokens.

    Attributes:
        input: For tokens read.
        cached: For tokens read that it had in its cache.
        output: For tokens written, those of reasoning included.
        batch: Factor on all three in its batch interface; None where it has none.
        date: When these prices were looked up, ISO 8601.
        source: Where.
    """

    input: float
    output: float
    cached: float
    batch: float | None
    date: str
    source: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelFacts:
    """What is known of a model. The defaults are safe for one of which nothing is known.

    Attributes:
        known: Whether a pattern fits its name.
        temperature: Whether it takes a temperature.
        top_p: Whether it takes top-p.
        efforts: Reasoning efforts that it takes, empty where it takes none.
        reasons: Whether it writes tokens that nobody sees before it replies.
        schema: How the form of its reply can be asked for.
        context: Tokens that a conversation may have; None where not known.
        most_output: Tokens that a reply may have; None where not known.
        images: Whether it can see; None where not known, then its provider has to say so.
        largest_image: Longest side in pixels of a picture that it sees as it is; None where not known.
        price: What it costs; None where not known.
    """

    known: bool = False
    temperature: bool = True
    top_p: bool = True
    efforts: tuple[str, ...] = ()
    reasons: bool = False
    schema: Schema = "strict"
    context: int | None = None
    most_output: int | None = None
    images: bool | None = None
    largest_image: int | None = None
    price: Price | None = None


def facts_of(name: str) -> ModelFacts:
    """What is known of a model.

    Args:
        name: As Inspect AI has it, for example ``openai/gpt-4o``; without options.
    """
    for entry in _entries():
        if any(fnmatchcase(name, pattern) for pattern in entry["match"]):
            given: dict[str, Any] = {f.name: entry[f.name] for f in fields(ModelFacts) if f.name in entry}
            if "price" in entry:
                given["price"] = Price(**entry["price"])
            return ModelFacts(**given | {"known": True, "efforts": tuple(entry.get("efforts", ()))})
    return ModelFacts()


@cache
def _entries() -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = tomllib.loads(Path(__file__).with_name("models.toml").read_text("utf-8"))["model"]
    return found
