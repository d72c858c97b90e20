"""A hosted model as it is asked: its options in a spec, what is known of it, and how it is reached.

``llm:openai/gpt-4o?temperature=0&images=4``
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Literal

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
        max_tokens: The most tokens of a reply, including reasoning. None for that of :attr:`Model.most_tokens`.
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Model:
    """A model with its options and what is known of it; it is named without them: ``openai/gpt-4o``.

    Raises:
        Conflict: If an option has no meaning for it.
    """

    name: str
    settings: ModelSettings = ModelSettings()
    facts: ModelFacts = field(default_factory=ModelFacts)

    @classmethod
    def parse(cls, spec: str) -> Model:
        """The model of a spec, with or without ``llm:``.

        Raises:
            UnknownName: If there is no such option.
            BadValue: If it names no model, or an option has an invalid value.
            BadFile: If the user's file of facts cannot be used.
        """
        asked = Spec.parse(spec.removeprefix("llm:"))
        name = asked.full_name
        parts = name.split("/")
        if len(parts) < 2 or any(part.strip() != part or part in ("", ".", "..") for part in parts):
            raise BadValue("language model", name, "PROVIDER/MODEL, for example openai/gpt-4o")
        return cls(name=name, settings=with_options(ModelSettings, f"llm:{name}", asked.options), facts=facts_of(name))

    def __post_init__(self) -> None:
        asked, name = self.settings, f"llm:{self.name}"
        if asked.upstream is not None and not self.name.startswith("openrouter/"):
            raise Conflict("upstream", name, "only OpenRouter chooses between providers")
        if self.facts.images is False and (asked.images, asked.detail) != (0, "high"):
            raise Conflict("images or detail", name, "this model cannot read pictures")

    @property
    def most_tokens(self) -> int | None:
        """The most tokens of a reply; None where its provider decides, as it is not known whether the model reasons."""
        known = self.facts
        if self.settings.max_tokens is not None:
            return self.settings.max_tokens
        if known.reasons is None:
            return known.most_output or UNBOUNDED if self.name.startswith("anthropic/") else None  # which needs one
        most = MOST_REASONED if self.reasons else MOST_PLAIN
        return min(most, known.most_output or most)

    @property
    def reasons(self) -> bool:
        """Whether it is known to write hidden reasoning tokens, with these options."""
        return bool(self.facts.reasons) if self.settings.effort is None else self.settings.effort != "none"

    @property
    def form(self) -> Schema:
        """How the form of the reply is requested."""
        return self.settings.schema or self.facts.schema or "strict"

    def parameters(self) -> dict[str, object]:
        """What is sent with a conversation, in the order and with the names of chat completions."""
        asked = self.settings
        given: dict[str, object] = {
            "max_tokens": self.most_tokens,
            "temperature": asked.temperature,
            "top_p": asked.top_p,
            "reasoning_effort": asked.effort,
            "upstream": asked.upstream,
        }
        return {name: value for name, value in given.items() if value is not None}

    def sent(self) -> dict[str, Fact]:
        """The parameters of every request, and those left to the provider, for the record."""
        asked, known, left = self.settings, self.facts, "provider default"
        sampling = "fixed by the model" if known.fixed else left
        found: dict[str, Fact] = {
            "temperature": sampling if asked.temperature is None else asked.temperature,
            "top_p": sampling if asked.top_p is None else asked.top_p,
            "effort": asked.effort or ("not taken" if known.effort is False else left),
            "max_tokens": self.most_tokens or left,
            "schema": self.form,
            "repairs": asked.repairs,
        }
        for option in fields(asked):
            value = getattr(asked, option.name)
            if option.name in ("upstream", "images", "detail") and value != option.default:
                found[option.name] = value
        return found if known.largest_image is None else found | {"largest_image": known.largest_image}


@dataclass(frozen=True, slots=True, kw_only=True)
class Access:
    """How hosted models are reached: concurrency and retries. It changes no request.

    Attributes:
        connections: Concurrent requests, at least 1.
        timeout: Seconds after which a hanging request is repeated.
        retries: How often an unanswered request is repeated before its trial ends as ``error``.
        pause: Seconds before the first retry, doubled for every further one up to a minute. A waiting time given by the
            provider takes precedence.
        connect: Seconds within which a server has to take a connection.

    Raises:
        BadValue: If a number is out of range.
    """

    connections: int = 10
    timeout: float = 120.0
    retries: int = 6
    pause: float = 0.5
    connect: float = 10.0

    def __post_init__(self) -> None:
        check_whole("connections", self.connections, 1, 10_000)
        if not 0.01 <= self.timeout <= 86_400:
            raise BadValue("timeout", self.timeout, "seconds from 0.01 to a day")
        check_whole("retries", self.retries, 0, 100)
        if not 0 <= self.pause <= 60:
            raise BadValue("pause", self.pause, "seconds from 0 to 60")
