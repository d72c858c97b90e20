"""Facts about models (``models.toml``): which options they accept, what they see, what they cost.

A second file of the same form, named by the environment variable :data:`OWN_FACTS`, adds and overrides entries. Values
that it leaves out stay as shipped. Prices that neither file has are those of the package ``genai-prices``.
"""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, fields
from datetime import date
from fnmatch import fnmatchcase
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field, TypeAdapter, ValidationError

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.inputs import read_toml
from lockprobe.foundation.terminal_text import printable
from lockprobe.foundation.validation import plain
from lockprobe.trial.model_call import Usage

OWN_FACTS = "LOCKPROBE_MODEL_FACTS"
"""Environment variable with the path of a user's file of facts."""

SHIPPED = Path(__file__).with_name("models.toml")

Schema = Literal["strict", "loose", "none"]
"""How the form of a reply can be requested: as an enforced schema, as a schema without enforcement, or in words."""

Effort = Literal["none", "minimal", "low", "medium", "high", "xhigh", "max"]
"""The reasoning effort of a model, from the least to the most."""

_Dollars = Annotated[float, Field(ge=0, le=1e6, allow_inf_nan=False, strict=True)]
_Count = Annotated[int, Field(ge=1, le=10**9, strict=True)]
_Whether = Annotated[bool, Field(strict=True)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Price:
    """A provider's prices, in US dollars per million tokens.

    Attributes:
        input: For tokens read.
        cached: For tokens read that the provider had in its cache; None if they cost as much as others.
        output: For tokens written, including reasoning.
        stored: For tokens read that the provider puts into its cache; None if they cost as much as others.
        date: When these prices were looked up, or the package that has them.
    """

    input: _Dollars
    cached: _Dollars | None = None
    output: _Dollars
    stored: _Dollars | None = None
    date: Annotated[str, BeforeValidator(str)]
    source: Annotated[str, Field(min_length=1, max_length=300), AfterValidator(printable)]

    def of(self, usage: Usage) -> float:
        """The cost of calls, in US dollars."""
        cached, stored = (self.input if one is None else one for one in (self.cached, self.stored))
        fresh = max(0, usage.input_tokens - usage.cached_tokens - usage.stored_tokens)
        dollars = fresh * self.input + usage.cached_tokens * cached + usage.stored_tokens * stored
        return (dollars + usage.output_tokens * self.output) / 1e6


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelFacts:
    """The known facts about a model; None where a fact is not known.

    Attributes:
        reasons: Whether it writes hidden reasoning tokens by default before it replies.
        schema: How strictly it can be made to follow the form of a reply.
        most_output: Tokens that a reply may have.
        images: Whether it can see; where not known, its provider has to say so.
        picture_tokens: Tokens that a picture of up to 1024 by 1024 pixels takes at most.
    """

    reasons: _Whether | None = None
    schema: Schema | None = None
    most_output: _Count | None = None
    images: _Whether | None = None
    picture_tokens: _Count | None = None
    price: Price | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry(ModelFacts):
    """One entry of a file of facts, for all models whose names match one of its patterns; ``*`` matches anything."""

    match: Annotated[tuple[Annotated[str, Field(min_length=1)], ...], Field(min_length=1)]


_SELLERS = {
    "grok": "x-ai",
    **{name: name for name in ("anthropic", "fireworks", "google", "groq", "mistral", "openai", "together")},
}
"""Providers with one price a model at any time, and their names in ``genai-prices``; routers are none."""


def facts_of(name: str) -> ModelFacts:
    """The known facts about a model, named without options: ``openai/gpt-4o``."""
    own = os.environ.get(OWN_FACTS)
    said: dict[str, Any] = {}
    for path in (SHIPPED, Path(own).expanduser()) if own else (SHIPPED,):
        entries = (one for one in read_facts(path) if any(fnmatchcase(name, pattern) for pattern in one.match))
        entry = next(entries, ModelFacts())
        known = {one.name: getattr(entry, one.name) for one in fields(ModelFacts)}
        said |= {fact: value for fact, value in known.items() if value is not None}
    return ModelFacts(**said)


def price_of(name: str) -> Price | None:
    """What a model costs, named without options; None if it is not known."""
    return facts_of(name).price or _sold(name)


@cache
def _sold(name: str) -> Price | None:
    provider, _, model = name.partition("/")
    if provider not in _SELLERS:
        return None
    from genai_prices import Usage as Counted  # takes half a second, and most studies ask no model
    from genai_prices import __version__, calc_price

    def million(**tokens: int) -> float:
        thousand = calc_price(Counted(**tokens), model, provider_id=_SELLERS[provider]).total_price
        return round(float(thousand) * 1000, 6)

    try:
        return Price(
            input=million(input_tokens=1000),
            cached=million(input_tokens=1000, cache_read_tokens=1000),
            stored=million(input_tokens=1000, cache_write_tokens=1000),
            output=million(output_tokens=1000),
            date=f"genai-prices {__version__}",
            source="https://github.com/pydantic/genai-prices",
        )
    except (LookupError, ValueError):
        return None


def price_lines(name: str) -> tuple[str, ...]:
    """Four lines of TOML with a made-up, high price of a model, to be corrected and put into a file of facts."""
    day = date.today().isoformat()  # noqa: DTZ011 - a day, in the user's own time
    return (
        "# US dollars per million tokens: put in what your provider asks",
        "[[model]]",
        f"match = [{json.dumps(name)}]",
        f'price = {{ input = 10.0, cached = 10.0, output = 50.0, date = "{day}", source = "made up" }}',
    )


@cache
def read_facts(path: Path) -> tuple[Entry, ...]:
    """The entries of a file of facts, in order; the first that matches a name counts."""
    try:
        reader = TypeAdapter(dict[Literal["model"], tuple[Entry, ...]])
        return reader.validate_python(read_toml(path), extra="forbid").get("model", ())
    except ValidationError as error:
        wrong = error.errors()[-1]  # a key that is missing comes before the one that stands there instead
        where = " ".join(str(part + 1 if isinstance(part, int) else part) for part in wrong["loc"])
        keys = ", ".join(key.name for key in fields(Price if "price" in wrong["loc"] else Entry))
        said = f" (keys are {keys})" if wrong["type"] == "unexpected_keyword_argument" else ""
        raise BadFile(path, printable(f"{where}: {plain(wrong['msg'])}{said}")) from None
