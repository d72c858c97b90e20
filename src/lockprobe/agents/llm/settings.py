"""A hosted model as it is asked: its options in a spec, what is known of it, and how it is reached.

``llm:openai/gpt-4o?temperature=0&images=4``
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from math import ceil
from typing import Annotated, Literal

from lockprobe.agents.llm.model_facts import Effort, ModelFacts, Schema, facts_of
from lockprobe.agents.prompt import Message
from lockprobe.foundation.errors import BadValue, Conflict
from lockprobe.foundation.spec import Spec, with_options
from lockprobe.foundation.validation import Checked, Within
from lockprobe.trial.model_call import Usage
from lockprobe.trial.record import Fact

MOST_PLAIN, MOST_REASONED, MOST_UNKNOWN = 1000, 25_000, 32_000
"""The default limits of a reply in tokens: without reasoning, where typical replies have 20 to 100; with it, the least
that OpenAI's guide to reasoning models recommends; and where a provider needs one and nothing is known of the model."""

_LEFT = "provider default"
"""What the record says of a parameter that is not sent."""

_ON_RECORD = ("temperature", "top_p", "effort", "max_tokens", "schema", "repairs")
"""The options of which the record says what was sent."""

PER_MESSAGE, FORM, MOST_PER_PICTURE, MOST_OUTPUT = 20, 500, 3000, 32_768
"""The most tokens that a call can take, where nothing else is known: around a message, for its role and marks of
beginning and end; for the form of the reply, of which ours has 84; for a picture of up to 1024 by 1024 pixels; and for
a reply without a limit."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelSettings(Checked):
    """The options of a model, each within its least and most. One that is None is not sent: the provider decides.

    Attributes:
        effort: The reasoning effort.
        max_tokens: The most tokens of a reply, including reasoning.
        schema: How the form of the reply is requested: as a schema that the provider enforces (``strict``), as one that
            it need not enforce (``loose``), or in words only (``none``).
        upstream: The provider behind OpenRouter that has to serve it, and no other.
        images: The number of newest observations that keep their pictures in the conversation; 0 for all.
        detail: The provider's level of detail for pictures, if it has one.
        repairs: How often a malformed reply is requested again before the trial ends as ``error``.
    """

    temperature: Annotated[float, Within(0, 2)] | None = None
    top_p: Annotated[float, Within(0.001, 1)] | None = None
    effort: Effort | None = None
    max_tokens: Annotated[int, Within(1, 10**7)] | None = None
    schema: Schema | None = None
    upstream: str | None = None
    images: Annotated[int, Within(0, 10**6)] = 0
    detail: Literal["auto", "low", "high"] = "high"
    repairs: Annotated[int, Within(0, 20)] = 4


@dataclass(frozen=True, slots=True, kw_only=True)
class Model:
    """A model with what is known of it; it is named without its options: ``openai/gpt-4o``.

    Where an option is not given, its settings hold what follows from the facts: the limit of a reply, which is left to
    the provider where it is not known whether the model reasons, and the strictest form of the reply that it accepts.
    """

    name: str
    settings: ModelSettings = ModelSettings()
    facts: ModelFacts = field(default_factory=ModelFacts)

    @classmethod
    def parse(cls, spec: str) -> Model:
        """The model of a spec, with or without ``llm:``."""
        asked = Spec.parse(spec.removeprefix("llm:"))
        name = asked.full_name
        parts = name.split("/")
        if len(parts) < 2 or any(part.strip() != part or part in ("", ".", "..") for part in parts):
            raise BadValue("language model", name, "PROVIDER/MODEL such as openai/gpt-4o, local or gguf:PATH")
        return cls(name=name, settings=with_options(ModelSettings, f"llm:{name}", asked.options), facts=facts_of(name))

    @classmethod
    def as_sent(cls, spec: str, facts: Mapping[str, Fact]) -> Model:
        """The model of a spec as it was asked by the facts on record, whatever is known of it now."""
        name, options = cls.parse(spec).name, dict(Spec.parse(spec).without(_ON_RECORD).options)
        options |= {one: str(facts[one]) for one in _ON_RECORD if facts.get(one) not in (None, _LEFT)}
        return cls(name=name, settings=with_options(ModelSettings, f"llm:{name}", options))

    def __post_init__(self) -> None:
        asked, known = self.settings, self.facts
        if asked.upstream is not None and not self.name.startswith("openrouter/"):
            raise Conflict("upstream", f"llm:{self.name}", "only OpenRouter chooses between providers")
        most = asked.max_tokens
        if most is None and known.reasons is not None:
            most = MOST_REASONED if self.reasons else MOST_PLAIN
            most = min(most, known.most_output or most)
        elif most is None and self.name.startswith("anthropic/"):  # which needs a limit
            most = known.most_output or MOST_UNKNOWN
        whole = replace(asked, max_tokens=most, schema=asked.schema or known.schema or "strict")
        object.__setattr__(self, "settings", whole)

    @property
    def reasons(self) -> bool:
        """Whether it is known to write hidden reasoning tokens, with these options."""
        return bool(self.facts.reasons) if self.settings.effort is None else self.settings.effort != "none"

    def parameters(self) -> dict[str, object]:
        """What is sent with a conversation, in the order and with the names of chat completions."""
        options = ("max_tokens", "temperature", "top_p", "effort", "upstream")
        given = {option: value for option in options if (value := getattr(self.settings, option)) is not None}
        return {"reasoning_effort" if option == "effort" else option: value for option, value in given.items()}

    def sent(self) -> dict[str, Fact]:
        """The parameters of every request, and those left to the provider, for the record."""
        asked = {option.name: (getattr(self.settings, option.name), option.default) for option in fields(self.settings)}
        found: dict[str, Fact] = {name: _LEFT if asked[name][0] is None else asked[name][0] for name in _ON_RECORD}
        return found | {name: value for name, (value, usual) in asked.items() if name not in found and value != usual}

    def at_most(self, messages: Sequence[Message]) -> Usage:
        """The maximum tokens of one call, whatever the model replies.

        A tokenizer makes no more tokens of a text than the text has bytes. Providers count a picture by area or by
        squares, and some scale large ones down first: never more than so much for every block of 1024 by 1024 pixels.
        """
        text = "".join([message.text for message in messages]).encode(errors="surrogatepass")
        tokens, blocks = len(text) + PER_MESSAGE * len(messages) + FORM, 0
        for png in [picture.png for message in messages for picture in message.pictures]:
            sides = [int.from_bytes(png[at : at + 4], "big") for at in (16, 20)] if png[12:16] == b"IHDR" else [1, 1]
            blocks += max(1, ceil(sides[0] / 1024)) * max(1, ceil(sides[1] / 1024))
        return Usage(
            calls=1,
            input_tokens=tokens + (self.facts.picture_tokens or MOST_PER_PICTURE) * blocks,
            output_tokens=self.settings.max_tokens or self.facts.most_output or MOST_OUTPUT,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Access(Checked):
    """How hosted models are reached: concurrency and retries. It changes no request.

    Attributes:
        connections: Concurrent requests.
        timeout: Seconds after which a hanging request is repeated.
        retries: How often an unanswered request is repeated before its trial ends as ``error``.
        pause: Seconds before the first retry, doubled for every further one up to a minute. A waiting time given by the
            provider takes precedence.
        connect: Seconds within which a server has to take a connection.
    """

    connections: Annotated[int, Within(1, 10_000)] = 10
    timeout: Annotated[float, Within(0.01, 86_400)] = 120.0
    retries: Annotated[int, Within(0, 100)] = 6
    pause: Annotated[float, Within(0, 60)] = 0.5
    connect: Annotated[float, Within(0.01, 86_400)] = 10.0
