"""Options of a hosted model in its spec: ``llm:openai/gpt-4o?temperature=0&images=4``."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Literal, get_args

from lockprobe.agents.llm.model_facts import Effort, ModelFacts, Schema, facts_of
from lockprobe.foundation.errors import BadValue, Conflict
from lockprobe.foundation.spec import Spec, with_options
from lockprobe.foundation.validation import check_whole
from lockprobe.trial.record import Fact

MOST_PLAIN = 1000
"""The default limit of a reply in tokens for models without reasoning; typical replies have 20 to 100."""

MOST_REASONED = 25_000
"""The default limit for models that reason: the least that OpenAI's guide to reasoning models recommends."""

UNBOUNDED = 32_000
"""The limit where a provider needs one and nothing is known of the model's."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelSettings:
    """The options of a model. Options that are None are not sent, so that the provider decides.

    Attributes:
        temperature: From 0 to 2.
        top_p: Above 0, at most 1.
        effort: The reasoning effort.
        max_tokens: The most tokens of a reply, including reasoning. None for the value of :meth:`most_tokens`.
        schema: How the form of the reply is requested: as a schema that the provider enforces (``strict``), as one that
            it need not enforce (``loose``), or in words only (``none``). None for the strictest that the model accepts.
        upstream: The provider behind OpenRouter that has to serve it, and no other.
        images: The number of newest observations that keep their pictures in the conversation; 0 for all.
        detail: The provider's level of detail for pictures, if it has one.
        repairs: How often a malformed reply is requested again before the trial ends as ``error``.

    Raises:
        BadValue: If a number is out of range.
    """

    temperature: float | None = None
    top_p: float | None = None
    effort: Effort | None = None
    max_tokens: int | None = None
    schema: Schema | None = None
    upstream: str | None = None
    images: int = 0
    detail: Literal["auto", "low", "high"] = "high"
    repairs: int = 4

    def __post_init__(self) -> None:
        if self.temperature is not None and not 0 <= self.temperature <= 2:
            raise BadValue("temperature", self.temperature, "a number from 0 to 2")
        if self.top_p is not None and not 0 < self.top_p <= 1:
            raise BadValue("top_p", self.top_p, "a number above 0, at most 1")
        if self.max_tokens is not None:
            check_whole("max_tokens", self.max_tokens, 1, 10**7)
        if self.images < 0:
            raise BadValue("images", self.images, "the number of observations that keep their pictures, 0 for all")
        check_whole("repairs", self.repairs, 0, 20)

    def most_tokens(self, facts: ModelFacts) -> int | None:
        """The most tokens of a reply; None if it is not known whether the model reasons: its provider decides."""
        if self.max_tokens is not None or facts.reasons is None:
            return self.max_tokens
        most = MOST_REASONED if self.reasons(facts) else MOST_PLAIN
        return min(most, facts.most_output or most)

    def reasons(self, facts: ModelFacts) -> bool:
        """Whether a model with these options is known to write hidden reasoning tokens."""
        return bool(facts.reasons) if self.effort is None else self.effort != "none"

    def form(self, facts: ModelFacts) -> Schema:
        """How the form of the reply is requested."""
        return self.schema or facts.schema or "strict"

    def parameters(self, facts: ModelFacts) -> dict[str, object]:
        """The parameters sent with the conversation, in the order and with the names of chat completions."""
        given: dict[str, object] = {
            "max_tokens": self.most_tokens(facts),
            "temperature": self.temperature,
            "top_p": self.top_p,
            "reasoning_effort": self.effort,
            "upstream": self.upstream,
        }
        return {name: value for name, value in given.items() if value is not None}

    def sent(self, facts: ModelFacts) -> dict[str, Fact]:
        """The parameters of every request, and those left to the provider, for the record."""
        left = "provider default"
        sampling = "fixed by the model" if facts.sampling == "fixed" else left
        found: dict[str, Fact] = {
            "temperature": sampling if self.temperature is None else self.temperature,
            "top_p": sampling if self.top_p is None else self.top_p,
            "effort": self.effort or ("not taken" if facts.efforts == () else left),
            "max_tokens": self.most_tokens(facts) or left,
            "schema": self.form(facts),
            "repairs": self.repairs,
        }
        for field in fields(self):
            if field.name in ("upstream", "images", "detail") and (value := getattr(self, field.name)) != field.default:
                found[field.name] = value
        if facts.largest_image is not None:
            found["largest_image"] = facts.largest_image
        return found

    def check(self, name: str, facts: ModelFacts) -> None:
        """Refuse options that a model is known to refuse, and no others.

        Raises:
            BadValue: If it would refuse one of these settings.
        """
        self._check_sampling(name, facts)
        if self.upstream is not None and not name.startswith("llm:openrouter/"):
            raise Conflict("upstream", name, "only OpenRouter chooses between providers")
        if self.effort is not None and facts.efforts is not None and self.effort not in facts.efforts:
            taken = f"one of {', '.join(facts.efforts)}" if facts.efforts else "no effort"
            raise BadValue("effort", self.effort, f"{taken} with {name}")
        if self.max_tokens is not None and facts.most_output is not None and self.max_tokens > facts.most_output:
            raise BadValue("max_tokens", self.max_tokens, f"at most {facts.most_output} with {name}")
        kinds = get_args(Schema)
        allowed = kinds if facts.schema is None else kinds[kinds.index(facts.schema) :]
        if self.schema is not None and self.schema not in allowed:
            raise BadValue("schema", self.schema, f"{' or '.join(allowed)} with {name}")
        if facts.images is False and (self.images, self.detail) != (0, "high"):
            raise Conflict("images or detail", name, "this model cannot read pictures")

    def _check_sampling(self, name: str, facts: ModelFacts) -> None:
        if facts.sampling is None:
            return
        may = {"free": True, "no effort": self.effort in (None, "none"), "effort none": self.effort == "none"}
        for option in ("temperature", "top_p"):
            if (value := getattr(self, option)) is not None and not may.get(facts.sampling, False):
                where = ", which fixes it" if facts.sampling == "fixed" else " unless with effort=none"
                raise BadValue(option, value, f"no {option} with {name}{where}")


def read_settings(spec: str) -> tuple[str, ModelSettings]:
    """The model's name and options from its spec, with or without ``llm:``.

    Raises:
        UnknownName: If there is no such option.
        BadValue: If an option has an invalid value, or one that this model is known to refuse.
        BadFile: If the user's file of facts cannot be used.
    """
    asked = Spec.parse(spec.removeprefix("llm:"))
    name = asked.full_name
    if len(parts := name.split("/")) < 2 or any(part.strip() != part or part in ("", ".", "..") for part in parts):
        raise BadValue("language model", name, "PROVIDER/MODEL, for example openai/gpt-4o")
    settings, facts = with_options(ModelSettings, f"llm:{name}", asked.options), facts_of(name)
    settings.check(f"llm:{name}", facts)
    if parts[0] == "anthropic" and settings.most_tokens(facts) is None:  # which needs one
        settings = replace(settings, max_tokens=facts.most_output or UNBOUNDED)
    return name, settings
