"""Hosted language models through Inspect AI's model layer: providers, retries and usage are its work, not ours."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from lockprobe.agents.prompt import conversation, example, fingerprint, parse_reply, repair, reply_schema
from lockprobe.errors import BadValue, Missing, ModelFault, ReplyFault
from lockprobe.record import Decision, Fact, Situation, Usage

try:
    import inspect_ai
    from inspect_ai._util.error import PrerequisiteError
    from inspect_ai.model import (
        ChatMessage,
        ChatMessageAssistant,
        ChatMessageUser,
        GenerateConfig,
        Model,
        ModelOutput,
        ResponseSchema,
        get_model,
    )
    from inspect_ai.util import JSONSchema
except ImportError as error:
    raise Missing(f"hosted models need the package {error.name}", "pip install 'lockprobe[providers]'") from error

__all__ = ["HostedModel", "check"]

REPAIRS = 2
"""How often a malformed reply is asked for again before the trial ends as ``error``."""

_CONFIG = GenerateConfig(max_retries=6, attempt_timeout=120, reasoning_summary="none", max_connections=64)


def check(name: str) -> None:
    """Find out whether a model can be asked at all.

    Raises:
        Missing: If a key or a provider's package is missing.
        BadValue: If there is no such provider.
    """
    _open(name)


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
        name: Model name as Inspect AI knows it, for example ``openai/gpt-4o``.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._model = _open(name)

    @property
    def facts(self) -> Mapping[str, Fact]:
        """Model name, library and settings."""
        return {
            "model": self._name,
            "runtime": f"inspect-ai {inspect_ai.__version__}",
            "prompt": f"chat {_prompt_fingerprint()}",
            "repairs": REPAIRS,
            "temperature": "provider default",
        }

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """Ask for the next joint. The stream is not used: a provider draws its own luck."""
        messages: list[ChatMessage] = [
            ChatMessageUser(content=message.text)
            if message.role == "user"
            else ChatMessageAssistant(content=message.text)
            for message in conversation(situation)
        ]
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


def _prompt_fingerprint() -> str:
    """What changes with any word that a model is sent, but for the sentences of the observation."""
    shown = example()
    texts = [message.text for message in conversation(shown)]
    return fingerprint(*texts, repair(ReplyFault("why"), shown), json.dumps(reply_schema(shown)))


def _add(usage: Usage, output: ModelOutput) -> Usage:
    spent = output.usage
    return Usage(
        calls=usage.calls + 1,
        input_tokens=usage.input_tokens + (spent.input_tokens if spent else 0),
        output_tokens=usage.output_tokens + (spent.output_tokens if spent else 0),
        cached_tokens=usage.cached_tokens + (spent.input_tokens_cache_read or 0 if spent else 0),
    )
