"""The client for language models: one request, one reply, through Inspect AI's model layer.

Only this module and :mod:`lockprobe.agents.llm.connect` use the model layer.
"""

from __future__ import annotations

import asyncio
import base64
import time
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from lockprobe.agents.llm.answer import reasoned_in, refuse_overflow, said_in, usage_of
from lockprobe.agents.llm.connect import config_of, mistake, opened
from lockprobe.agents.llm.inspect_internals import PrerequisiteError
from lockprobe.agents.llm.model_facts import facts_of
from lockprobe.agents.llm.retry import Again, Declined, Judgement, with_retries
from lockprobe.agents.llm.settings import ModelSettings
from lockprobe.agents.model_access import Access
from lockprobe.agents.prompt import Message
from lockprobe.foundation.errors import needing
from lockprobe.foundation.redaction import without_keys
from lockprobe.foundation.terminal_text import printable
from lockprobe.trial.model_call import Usage

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
        ModelOutput,
        ResponseSchema,
        RetryDecision,
    )
    from inspect_ai.util import JSONSchema

RUNTIME = f"inspect-ai {inspect_ai.__version__}"

LONGEST_REPLY = 100_000
"""The most characters kept of a reply; typical replies have a few hundred."""

LONGEST_NAME = 200
"""The most characters kept of the name of a model that answered."""


_NO_NAME = ""
"""The name of every message: to draw one for each takes longer than to make the message."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelReply:
    """The reply of a model.

    Attributes:
        text: The reply.
        stop: Why the model stopped, as :attr:`lockprobe.trial.model_call.Call.stop` has it.
        served: The model that answered, as the provider names it.
        usage: What it cost, with what the provider counted for failed attempts.
        seconds: Wall time, retries included.
        retries: How often the provider had to be asked again.
        unanswered: Attempts without a usable reply that the provider may have charged for.
        reasoned: Whether reasoning came with it, apart from the text.
    """

    text: str
    stop: str
    served: str
    usage: Usage
    seconds: float
    retries: int = 0
    unanswered: int = 0
    reasoned: bool = False


class ModelClient:
    """An open client of one model, named as Inspect AI knows it.

    Attributes:
        slots: Free slots for concurrent requests; each request holds one.

    Raises:
        UserMistake: As :func:`lockprobe.agents.llm.connect.opened`.
    """

    def __init__(self, name: str, settings: ModelSettings, access: Access) -> None:
        warnings.filterwarnings("ignore", "Pydantic serializer warnings", UserWarning)  # they quote what came
        self._name, self._settings, facts = name, settings, facts_of(name)
        self._form = settings.form(facts)
        self._access = access
        self._model = opened(name, access, settings.parameters(facts))
        self._config = config_of(self._model)
        self.slots = asyncio.Semaphore(access.connections)

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
        conversation = [sent(message, self._settings, _NO_NAME) for message in messages]
        config = self._config.model_copy(update={"response_schema": form})
        began = time.perf_counter()
        came, tries = await with_retries(partial(self._once, conversation, config), self._judge, self._access, again)
        output, text, stop = came
        refuse_overflow(output, tries)
        usage = usage_of(output)
        bare = tries.lost != Usage() and not (usage.input_tokens or usage.output_tokens)  # the sum would hide it
        return ModelReply(
            text=without_keys(text)[:LONGEST_REPLY],
            stop=stop,
            served=printable(without_keys(output.model))[:LONGEST_NAME],
            usage=usage + tries.lost,
            seconds=time.perf_counter() - began,
            retries=tries.retries,
            unanswered=tries.unanswered + bare,
            reasoned=reasoned_in(output),
        )

    @property
    def filled_in(self) -> dict[str, int]:
        """Parameters sent by default because Inspect AI knows that the provider requires them."""
        return {} if self._config.max_tokens is None else {"max_tokens": self._config.max_tokens}

    def _judge(self, error: Exception) -> Judgement:
        if isinstance(error, Declined):
            return error
        decision = self._model.api.should_retry(error)
        if isinstance(decision, RetryDecision) and decision.retry:
            return decision
        return RetryDecision.transient() if self._model.should_retry(error) else RetryDecision.no()

    async def _once(self, conversation: list[ChatMessage], config: GenerateConfig) -> tuple[ModelOutput, str, str]:
        """One request through the provider's interface, because ``Model.generate`` keeps a log in memory.

        The text of the reply and the reason for its end stand beside the output.
        """
        try:
            came = await self._model.api.generate(conversation, tools=[], tool_choice="none", config=config)
        except PrerequisiteError as error:
            raise mistake(self._name, error) from None
        output, body = (came[0], came[1].response) if isinstance(came, tuple) else (came, None)
        if isinstance(output, Exception):
            raise output
        return output, *said_in(output, body)

    async def aclose(self) -> None:
        """Close the provider's connections."""
        await self._model.api.aclose()


def sent(message: Message, settings: ModelSettings, name: str | None = None) -> ChatMessage:
    """A message as it is sent. Its name is for Inspect AI's logs and is not sent; None for one that it draws itself."""
    if message.role == "assistant":
        return ChatMessageAssistant(content=message.text, id=name)
    if not message.pictures:
        return ChatMessageUser(content=message.text, id=name)
    content: list[Content] = [ContentText(text=message.text)]
    for picture in message.pictures:
        data = base64.b64encode(picture.png).decode("ascii")
        content.append(ContentImage(image=f"data:image/png;base64,{data}", detail=settings.detail))
    return ChatMessageUser(content=content, id=name)
