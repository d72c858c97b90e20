"""The line to a provider, through Inspect AI's model layer: one request, one answer. Nothing else imports it here."""

from __future__ import annotations

import asyncio
import base64
import logging
import os
import re
import sys
import time
from collections.abc import Awaitable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any
from urllib.parse import urlsplit

from lockprobe.agents.access import Access
from lockprobe.agents.llm.knowledge import facts_of
from lockprobe.agents.llm.patience import patiently
from lockprobe.agents.llm.plainly import send_plainly
from lockprobe.agents.llm.settings import Settings
from lockprobe.agents.prompt import Message
from lockprobe.call import Usage
from lockprobe.errors import BadValue, Missing, without_keys

try:
    import inspect_ai
    from inspect_ai._util.error import PrerequisiteError
    from inspect_ai.model import (
        BatchConfig,
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
        RetryDecision,
        get_model,
    )
    from inspect_ai.model._providers.util.batch_log import set_batch_log_callback
    from inspect_ai.util import JSONSchema
except ImportError as error:
    raise Missing(f"hosted models need the package {error.name}", "pip install 'lockprobe[providers]'") from error

__all__ = ["RUNTIME", "WITH_BATCHES", "Answer", "Line", "host_of", "sent", "usage_of"]

RUNTIME = f"inspect-ai {inspect_ai.__version__}"

_log = logging.getLogger(__name__)

WITH_BATCHES = ("anthropic", "google", "grok", "openai", "together")
"""Providers whose batch interface Inspect AI knows."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Answer:
    """What came back.

    Attributes:
        text: The reply.
        stop: Why the model stopped, as Inspect AI names it.
        served: The model that answered, as the provider names it.
        usage: What it cost.
        seconds: Wall time, retries included.
        retries: How often the provider had to be asked again.
    """

    text: str
    stop: str
    served: str
    usage: Usage
    seconds: float
    retries: int = 0


class Line:
    """An open line to one model.

    Args:
        name: The model as Inspect AI knows it.
        settings: How it is asked.
        access: How it is reached.

    Attributes:
        slots: Requests that may still go on their way at once; whoever asks holds one.
        batch: Whether requests go through the provider's batch interface.

    Raises:
        Missing: If a key or a provider's package is missing.
        BadValue: If there is no such provider, or it has no batch interface and one is asked for.
    """

    def __init__(self, name: str, settings: Settings, access: Access) -> None:
        self._name, self._settings, facts = name, settings, facts_of(name)
        self._form = settings.form(facts)
        self._access = access
        self.batch = access.batch
        self._open = partial(_open, name, access, settings.parameters(facts))
        self._model, self._left = self._open(), list[Model]()
        self._config = _config(self._model)
        self.slots = asyncio.Semaphore(sys.maxsize if access.batch else access.connections)

    @property
    def host(self) -> str | None:
        """Whose machine is asked, where somebody said so; None for the provider's own."""
        return host_of(self._name)

    async def ask(self, messages: Sequence[Message], schema: dict[str, object]) -> Answer:
        """Send a conversation and wait for the reply. The caller holds one of :attr:`slots`.

        Args:
            messages: The conversation.
            schema: The form of the reply.

        Raises:
            ModelFault: If the provider gives no answer, after all retries.
        """
        form = None
        if self._form != "none":
            json_schema = JSONSchema.model_validate(schema)
            form = ResponseSchema(name="reply", json_schema=json_schema, strict=self._form == "strict")
        conversation = [sent(message, self._settings) for message in messages]
        config = self._config.model_copy(update={"response_schema": form})
        began = time.perf_counter()
        asked = self._model

        def once() -> Awaitable[ModelOutput]:
            nonlocal asked
            asked = self._model
            return _once(asked, conversation, config)

        output, retries = await patiently(once, lambda error: self._judge(asked, error), self._access)
        return Answer(
            text=without_keys(output.completion),
            stop=output.stop_reason,
            served=without_keys(output.model),
            usage=usage_of(output),
            seconds=time.perf_counter() - began,
            retries=retries,
        )

    def _judge(self, asked: Model, error: Exception) -> RetryDecision:
        if self._access.batch and asked is self._model:  # Inspect AI sends no more batches after one that it could not
            self._left.append(asked)
            self._model = self._open()
        judged = asked.api.should_retry(error)
        if isinstance(judged, RetryDecision) and judged.retry:
            return judged
        return RetryDecision.transient() if asked.should_retry(error) else RetryDecision.no()

    async def aclose(self) -> None:
        """Close the provider's connections."""
        for model in (*self._left, self._model):
            await model.api.aclose()


async def _once(model: Model, conversation: list[ChatMessage], config: GenerateConfig) -> ModelOutput:
    """One request by the provider's own interface: ``Model.generate`` keeps all it did in memory, for a log."""
    came = await model.api.generate(conversation, tools=[], tool_choice="none", config=config)
    output = came[0] if isinstance(came, tuple) else came
    if isinstance(output, Exception):
        raise output
    if not output.choices:
        raise ValueError("it holds no reply")
    return output


def _open(name: str, access: Access, parameters: dict[str, object]) -> Model:
    config = GenerateConfig(reasoning_summary="none", max_retries=access.retries, batch=_batch(name, access))
    try:
        model = get_model(name, config=config.model_copy(update=parameters), memoize=False)
    except (PrerequisiteError, ValueError) as error:
        said = " ".join(re.sub(r"\[/?[a-z ]*\]|ERROR:?", "", str(error)).split())
        if keys := re.findall(r"[A-Z][A-Z0-9_]*_(?:KEY|TOKEN|URL)\b", said):
            raise Missing(f"llm:{name} needs {keys[0]}", f"export {keys[0]}=… and run again") from None
        if package := re.search(r"pip install (\S+)", said):
            raise Missing(f"llm:{name} needs the package {package[1]}", f"pip install {package[1]}") from None
        raise BadValue("language model", name, f"PROVIDER/MODEL as Inspect AI names it ({said})") from None
    client: Any = getattr(model.api, "client", None)
    if not access.batch and hasattr(client, "max_retries"):
        client.max_retries, client.timeout = 0, None  # so that all waiting is ours, and counted
    send_plainly(client)
    return model


def _batch(name: str, access: Access) -> BatchConfig | None:
    if not access.batch:
        return None
    if name.partition("/")[0] not in WITH_BATCHES:
        raise BadValue("batch", name, f"a model of a provider that has batches: {', '.join(WITH_BATCHES)}")
    set_batch_log_callback(_log.info)  # else it is printed, between our own lines
    logging.getLogger("asyncio").addFilter(_is_news)
    return BatchConfig(tick=access.tick, send_delay=access.tick)


def host_of(name: str) -> str | None:
    """Whose machine is asked for a model, where somebody said so; None for the provider's own."""
    provider, service, *_ = f"{name}/".split("/")
    whose = (service if provider == "openai-api" else provider).upper().replace("-", "_")
    url = os.environ.get(f"{whose}_BASE_URL") or os.environ.get("INSPECT_EVAL_MODEL_BASE_URL") or ""
    try:
        return urlsplit(url).hostname
    except ValueError:
        return None


def _is_news(record: logging.LogRecord) -> bool:
    """Whether an exception that nobody asked for is not that of a batch, which its requests have raised already."""
    return record.exc_info is None or "escaped from background task" not in str(record.exc_info[1])


def _config(model: Model) -> GenerateConfig:
    """What is sent with every request; some providers insist on a bound of the reply."""
    config = model.config
    if config.max_tokens is None:
        config = config.model_copy(
            update={"max_tokens": model.api.max_tokens_for_config(config) or model.api.max_tokens()}
        )
    return config


def sent(message: Message, settings: Settings) -> ChatMessage:
    """A message as it is sent."""
    if message.role == "assistant":
        return ChatMessageAssistant(content=message.text)
    if not message.pictures:
        return ChatMessageUser(content=message.text)
    content: list[Content] = [ContentText(text=message.text)]
    for picture in message.pictures:
        data = base64.b64encode(picture.png).decode("ascii")
        content.append(ContentImage(image=f"data:image/png;base64,{data}", detail=settings.detail))
    return ChatMessageUser(content=content)


def usage_of(output: ModelOutput) -> Usage:
    """What a reply cost, as its provider counts; a count that cannot be is none."""
    if (spent := output.usage) is None:
        return Usage(calls=1)
    cached, stored = _count(spent.input_tokens_cache_read), _count(spent.input_tokens_cache_write)
    read = _count(spent.input_tokens) + cached + stored  # Inspect AI leaves both out
    return Usage(
        calls=1,
        input_tokens=read,
        output_tokens=_count(max(spent.output_tokens, spent.total_tokens - read)),  # xAI leaves out those of reasoning
        cached_tokens=cached,
        stored_tokens=stored,
        reasoning_tokens=_count(spent.reasoning_tokens),
    )


def _count(tokens: int | None) -> int:
    return tokens if tokens is not None and 0 <= tokens < 2**40 else 0
