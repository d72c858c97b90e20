"""The line to a provider, through Inspect AI's model layer: one request, one answer. Nothing else imports it here."""

from __future__ import annotations

import base64
import re
import time
from collections.abc import Sequence
from dataclasses import dataclass

from lockprobe.agents.access import Access
from lockprobe.agents.llm.settings import Settings
from lockprobe.agents.prompt import Message
from lockprobe.call import Usage
from lockprobe.errors import BadValue, Missing, ModelFault

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

__all__ = ["RUNTIME", "Answer", "Line"]

RUNTIME = f"inspect-ai {inspect_ai.__version__}"


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

    Raises:
        Missing: If a key or a provider's package is missing.
        BadValue: If there is no such provider.
    """

    def __init__(self, name: str, settings: Settings, access: Access) -> None:
        self._settings = settings
        self._model = _open(name, access)

    async def ask(self, messages: Sequence[Message], schema: dict[str, object]) -> Answer:
        """Send a conversation and wait for the reply.

        Args:
            messages: The conversation.
            schema: The form of the reply.

        Raises:
            ModelFault: If the provider gives no answer, after all retries.
        """
        form = ResponseSchema(name="reply", json_schema=JSONSchema.model_validate(schema), strict=True)
        began = time.perf_counter()
        try:
            output = await self._model.generate(
                [_sent(message, self._settings) for message in messages], config=GenerateConfig(response_schema=form)
            )
        except RuntimeError as error:  # its own text repeats the whole request
            if (said := getattr(error, "provider_message", None)) is None:
                raise
            raise ModelFault(f"the provider answered {getattr(error, 'status_code', None)}: {said}") from error
        return Answer(
            text=output.completion,
            stop=output.stop_reason,
            served=output.model,
            usage=_usage(output),
            seconds=time.perf_counter() - began,
        )

    async def aclose(self) -> None:
        """Close the provider's connections."""
        await self._model.api.aclose()


def _open(name: str, access: Access) -> Model:
    config = GenerateConfig(
        max_retries=access.retries,
        attempt_timeout=max(1, round(access.timeout)),
        reasoning_summary="none",
        max_connections=access.connections,
    )
    try:
        return get_model(name, config=config, memoize=False)
    except (PrerequisiteError, ValueError) as error:
        said = " ".join(re.sub(r"\[/?[a-z ]*\]|ERROR:?", "", str(error)).split())
        if keys := re.findall(r"[A-Z][A-Z0-9_]*_(?:KEY|TOKEN|URL)\b", said):
            raise Missing(f"llm:{name} needs {keys[0]}", f"export {keys[0]}=… and run again") from None
        if package := re.search(r"pip install (\S+)", said):
            raise Missing(f"llm:{name} needs the package {package[1]}", f"pip install {package[1]}") from None
        raise BadValue("language model", name, f"PROVIDER/MODEL as Inspect AI names it ({said})") from None


def _sent(message: Message, settings: Settings) -> ChatMessage:
    if message.role == "assistant":
        return ChatMessageAssistant(content=message.text)
    if not message.pictures:
        return ChatMessageUser(content=message.text)
    content: list[Content] = [ContentText(text=message.text)]
    for picture in message.pictures:
        data = base64.b64encode(picture.png).decode("ascii")
        content.append(ContentImage(image=f"data:image/png;base64,{data}", detail=settings.detail))
    return ChatMessageUser(content=content)


def _usage(output: ModelOutput) -> Usage:
    if (spent := output.usage) is None:
        return Usage(calls=1)
    return Usage(
        calls=1,
        input_tokens=spent.input_tokens,
        output_tokens=spent.output_tokens,
        cached_tokens=spent.input_tokens_cache_read or 0,
        reasoning_tokens=spent.reasoning_tokens or 0,
    )
