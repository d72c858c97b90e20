"""The client for language models: one request, one reply, through Inspect AI's model layer.

Only this module and :mod:`lockprobe.agents.llm.connect` use the model layer.
"""

from __future__ import annotations

import asyncio
import base64
import sys
import time
import warnings
from collections.abc import Awaitable, Sequence
from dataclasses import asdict, dataclass
from functools import partial

from lockprobe.agents.llm.connect import config_of, mistake, opened
from lockprobe.agents.llm.inspect_internals import PrerequisiteError
from lockprobe.agents.llm.model_facts import facts_of
from lockprobe.agents.llm.retry import Again, Declined, Tries, with_retries
from lockprobe.agents.llm.settings import ModelSettings
from lockprobe.agents.model_access import Access
from lockprobe.agents.prompt import Message
from lockprobe.errors import ModelFault, needing
from lockprobe.model_call import Usage
from lockprobe.redaction import without_keys
from lockprobe.terminal_text import printable

with needing("hosted models", "providers"):
    import inspect_ai
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
        RetryDecision,
    )
    from inspect_ai.util import JSONSchema

__all__ = ["RUNTIME", "ModelClient", "ModelReply", "refuse_overflow", "sent", "usage_of"]

RUNTIME = f"inspect-ai {inspect_ai.__version__}"

LONGEST_REPLY = 100_000
"""The most characters kept of a reply; typical replies have a few hundred."""

LONGEST_NAME = 200
"""The most characters kept of the name of a model that answered."""

_MOST_COUNTED = 2**40

_ONCE = Tries()


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelReply:
    """The reply of a model.

    Attributes:
        text: The reply.
        stop: Why the model stopped, as Inspect AI names it.
        served: The model that answered, as the provider names it.
        usage: What it cost.
        seconds: Wall time, retries included.
        retries: How often the provider had to be asked again.
        unanswered: Attempts without a usable reply that the provider may have charged for.
    """

    text: str
    stop: str
    served: str
    usage: Usage
    seconds: float
    retries: int = 0
    unanswered: int = 0


class ModelClient:
    """An open client of one model, named as Inspect AI knows it.

    Attributes:
        slots: Free slots for concurrent requests; each request holds one.
        batch: Whether requests go through the provider's batch interface.

    Raises:
        UserMistake: As :func:`lockprobe.agents.llm.connect.opened`.
    """

    def __init__(self, name: str, settings: ModelSettings, access: Access) -> None:
        warnings.filterwarnings("ignore", "Pydantic serializer warnings", UserWarning)  # they quote what came
        self._name, self._settings, facts = name, settings, facts_of(name)
        self._form = settings.form(facts)
        self._access = access
        self.batch = access.batch
        self._open = partial(opened, name, access, settings.parameters(facts))
        self._model, self._left = self._open(), list[Model]()
        self._config = config_of(self._model)
        self.slots = asyncio.Semaphore(sys.maxsize if access.batch else access.connections)

    async def ask(
        self, messages: Sequence[Message], schema: dict[str, object], again: Again | None = None
    ) -> ModelReply:
        """Send a conversation and wait for a reply of the form ``schema``. The caller holds one of :attr:`slots`.

        ``again`` is called before a request is made again that may have been charged for.

        Raises:
            ModelFault: If the provider gives no answer, after all retries, or the conversation is too long.
            Missing: If only now it turns out that something is not there.
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
            return self._once(asked, conversation, config)

        output, tries = await with_retries(once, lambda error: self._judge(asked, error), self._access, again)
        refuse_overflow(output, tries)
        return ModelReply(
            text=without_keys(output.completion)[:LONGEST_REPLY],
            stop=output.stop_reason,
            served=printable(without_keys(output.model))[:LONGEST_NAME],
            usage=usage_of(output),
            seconds=time.perf_counter() - began,
            retries=tries.retries,
            unanswered=tries.unanswered,
        )

    @property
    def filled_in(self) -> dict[str, int]:
        """Parameters sent by default because Inspect AI knows that the provider requires them."""
        return {} if self._config.max_tokens is None else {"max_tokens": self._config.max_tokens}

    def _judge(self, asked: Model, error: Exception) -> RetryDecision:
        if self._access.batch and asked is self._model:  # Inspect AI sends no more batches after one that it could not
            self._left.append(asked)
            self._model = self._open()
        if isinstance(error, Declined):
            judged = RetryDecision.rate_limit() if error.status_code == 429 else RetryDecision.transient()
            return judged if error.passes else RetryDecision.no()
        decision = asked.api.should_retry(error)
        if isinstance(decision, RetryDecision) and decision.retry:
            return decision
        return RetryDecision.transient() if asked.should_retry(error) else RetryDecision.no()

    async def _once(self, model: Model, conversation: list[ChatMessage], config: GenerateConfig) -> ModelOutput:
        """One request through the provider's interface, because ``Model.generate`` keeps a log in memory."""
        try:
            came = await model.api.generate(conversation, tools=[], tool_choice="none", config=config)
        except PrerequisiteError as error:
            raise mistake(self._name, error) from None
        output = came[0] if isinstance(came, tuple) else came
        if isinstance(output, Exception):
            raise output
        if not output.choices:
            raise ValueError("it holds no reply")
        return output

    async def aclose(self) -> None:
        """Close the provider's connections."""
        for model in (*self._left, self._model):
            await model.api.aclose()


def refuse_overflow(output: ModelOutput, tries: Tries = _ONCE) -> None:
    """Refuse the reply that Inspect AI substitutes for the provider's error about a conversation that is too long.

    Raises:
        ModelFault: If that is what came.
    """
    if output.stop_reason != "model_length":
        return
    counted = output.usage is not None
    said = "" if counted else f": {' '.join(output.completion.split())}"
    spent = asdict(usage_of(output)) if counted else {}
    raise ModelFault(f"the conversation is longer than the model can read{said}", **tries._asdict(), usage=spent)


def sent(message: Message, settings: ModelSettings) -> ChatMessage:
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
    """The cost of a reply by its provider's counts; if one count is impossible, none is used."""
    if (spent := output.usage) is None:
        return Usage(calls=1)
    cached, stored = spent.input_tokens_cache_read or 0, spent.input_tokens_cache_write or 0
    read = spent.input_tokens + cached + stored  # Inspect AI leaves both out
    written = max(spent.output_tokens, spent.total_tokens - read)  # xAI leaves out those of reasoning
    reasoned = spent.reasoning_tokens or 0
    if not all(0 <= count < _MOST_COUNTED for count in (spent.input_tokens, cached, stored, written, reasoned)):
        return Usage(calls=1)
    return Usage(
        calls=1,
        input_tokens=read,
        output_tokens=written,
        cached_tokens=cached,
        stored_tokens=stored,
        reasoning_tokens=reasoned,
    )
