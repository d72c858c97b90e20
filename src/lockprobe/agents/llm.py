"""Hosted language models through Inspect AI's model layer: providers, retries and usage are its work, not ours.

A percept's pictures are sent as they are, as PNG, after its text; those of earlier percepts stay in the conversation,
as the paper's did, or only the newest: ``llm:openai/gpt-4o?images=4``. Whether a model can see is for its provider to
say.
"""

from __future__ import annotations

import base64
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Literal

import numpy as np

from lockprobe.agents.prompt import (
    Message,
    chat_fingerprint,
    conversation,
    parse_reply,
    picture_fingerprint,
    repair,
    reply_schema,
)
from lockprobe.errors import BadValue, Missing, ModelFault, ReplyFault
from lockprobe.options import read_options, with_options
from lockprobe.record import Decision, Fact, Situation, Usage

try:
    import inspect_ai
    from inspect_ai._util.error import PrerequisiteError
    from inspect_ai.model import (
        ChatMessage,
        ChatMessageAssistant,
        ChatMessageUser,
        Content,
        ContentImage,
        ContentText,
        GenerateConfig,
        Model,
        ModelOutput,
        ResponseSchema,
        get_model,
    )
    from inspect_ai.util import JSONSchema
except ImportError as error:
    raise Missing(f"hosted models need the package {error.name}", "pip install 'lockprobe[providers]'") from error

__all__ = ["HostedModel", "Showing", "check"]

REPAIRS = 2
"""How often a malformed reply is asked for again before the trial ends as ``error``."""

_CONFIG = GenerateConfig(max_retries=6, attempt_timeout=120, reasoning_summary="none", max_connections=64)


@dataclass(frozen=True, slots=True, kw_only=True)
class Showing:
    """How pictures are shown to a model: the options in its spec.

    Attributes:
        images: How many observations, the newest, keep their pictures in the conversation; 0 for all.
        detail: How closely the provider is asked to look, where it offers that.

    Raises:
        BadValue: If ``images`` is negative.
    """

    images: int = 0
    detail: Literal["auto", "low", "high"] = "high"

    def __post_init__(self) -> None:
        if self.images < 0:
            raise BadValue("images", self.images, "how many observations keep their pictures, 0 for all")


def check(spec: str) -> None:
    """Find out whether a model can be asked at all.

    Raises:
        Missing: If a key or a provider's package is missing.
        BadValue: If there is no such provider, or an option has a value that it cannot have.
        UnknownName: If there is no such option.
    """
    name, _ = _read(spec)
    _open(name)


def _read(spec: str) -> tuple[str, Showing]:
    name, options = read_options(spec)
    return name, with_options(Showing, f"llm:{name}", options)


def _open(name: str) -> Model:
    try:
        return get_model(name, config=_CONFIG, memoize=False)
    except (PrerequisiteError, ValueError) as error:
        said = " ".join(re.sub(r"\[/?[a-z ]*\]|ERROR:?", "", str(error)).split())
        if keys := re.findall(r"[A-Z][A-Z0-9_]*_(?:KEY|TOKEN|URL)\b", said):
            raise Missing(f"llm:{name} needs {keys[0]}", f"export {keys[0]}=… and run again") from None
        if package := re.search(r"pip install (\S+)", said):
            raise Missing(f"llm:{name} needs the package {package[1]}", f"pip install {package[1]}") from None
        raise BadValue("language model", name, f"PROVIDER/MODEL as Inspect AI names it ({said})") from None


class HostedModel:
    """A model behind a provider's interface, asked once per step.

    A reply that is not of the form asked for is asked again at most :data:`REPAIRS` times; every raw reply is kept.

    Args:
        spec: Model name as Inspect AI knows it and how pictures are shown to it, for example
            ``openai/gpt-4o?images=4``.
    """

    def __init__(self, spec: str) -> None:
        self._name, self._showing = _read(spec)
        self._model = _open(self._name)

    @property
    def facts(self) -> Mapping[str, Fact]:
        """Model name, library and settings."""
        return {
            "model": self._name,
            "runtime": f"inspect-ai {inspect_ai.__version__}",
            "prompt": f"chat {chat_fingerprint()}",
            "picture_prompt": f"chat {picture_fingerprint()}",
            "repairs": REPAIRS,
            "temperature": "provider default",
            **({} if self._showing == Showing() else asdict(self._showing)),
        }

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """Ask for the next joint. The stream is not used: a provider draws its own luck."""
        messages = [self._sent(message) for message in conversation(situation, images=self._showing.images)]
        replies: list[str] = []
        usage = Usage()
        while True:
            output = await self._ask(messages, situation)
            replies.append(output.completion)
            usage = _add(usage, output)
            try:
                decision = parse_reply(output.completion, situation)
                return replace(decision, replies=tuple(replies), usage=usage)
            except ReplyFault as fault:
                if len(replies) > REPAIRS:
                    raise ReplyFault(f"no usable reply in {len(replies)} turns: {fault}", tuple(replies)) from None
                messages += [
                    ChatMessageAssistant(content=output.completion or "(empty)"),
                    ChatMessageUser(content=repair(fault, situation)),
                ]

    def _sent(self, message: Message) -> ChatMessage:
        if message.role == "assistant":
            return ChatMessageAssistant(content=message.text)
        if not message.pictures:
            return ChatMessageUser(content=message.text)
        content: list[Content] = [ContentText(text=message.text)]
        for picture in message.pictures:
            data = base64.b64encode(picture.png).decode("ascii")
            content.append(ContentImage(image=f"data:image/png;base64,{data}", detail=self._showing.detail))
        return ChatMessageUser(content=content)

    async def _ask(self, messages: list[ChatMessage], situation: Situation) -> ModelOutput:
        schema = ResponseSchema(
            name="reply", json_schema=JSONSchema.model_validate(reply_schema(situation)), strict=True
        )
        try:
            return await self._model.generate(messages, config=GenerateConfig(response_schema=schema))
        except RuntimeError as error:  # its own text repeats the whole request
            if (said := getattr(error, "provider_message", None)) is None:
                raise
            raise ModelFault(f"the provider answered {getattr(error, 'status_code', None)}: {said}") from error

    async def aclose(self) -> None:
        """Close the provider's connections."""
        await self._model.api.aclose()


def _add(usage: Usage, output: ModelOutput) -> Usage:
    spent = output.usage
    return Usage(
        calls=usage.calls + 1,
        input_tokens=usage.input_tokens + (spent.input_tokens if spent else 0),
        output_tokens=usage.output_tokens + (spent.output_tokens if spent else 0),
        cached_tokens=usage.cached_tokens + (spent.input_tokens_cache_read or 0 if spent else 0),
    )
