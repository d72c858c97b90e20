"""Checks and straightens the answers of servers with OpenAI's interface, before Inspect AI reads them.

Servers send errors with status 200: in place of the reply, beside it, or inside the choice. OpenAI's client takes them
for an empty reply, so they are raised here, while the server's words are available. Refusals get one form, and content
in parts becomes one text. Other servers leave out the model's name or the counts of tokens; that costs a study no
reply.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from pydantic import BaseModel

from lockprobe.agents.llm.answer import kind_of_stop
from lockprobe.agents.llm.openai_client import is_openai
from lockprobe.agents.llm.retry import Declined
from lockprobe.agents.prompt import REFUSED
from lockprobe.trial.model_call import Usage

if TYPE_CHECKING:
    from openai import APIStatusError

_FAILURES = frozenset(map(str, range(400, 600)))
"""Error codes that are HTTP statuses; some servers write them as text, and most other codes are words."""

_REFUSING = (400, 403, 422, 451)
_REFUSED_FOR = re.compile(
    r"content.?(?:filter|policy|risk)|safety|moderation|flagged|invalid.?prompt|data.?inspection|prohibited",
    re.IGNORECASE,
)
_REFUSED_IN_WORDS = re.compile(r"content exists risk|inappropriate content|requires moderation", re.IGNORECASE)
"""The statuses of a refusal, and how its code or type names it; few services say it in words alone."""

_UNFINISHED = ("queued", "in_progress")

_CUT_OFF = ("length", "max_tokens", "max_output_tokens")
_REASONING = ("reasoning", "reasoning_content", "reasoning_details")
_CALLS = ("tool_calls", "function_call")


def check_answers(client: object) -> None:
    """Make an OpenAI client check every answer that is not streamed; leave other clients as they are."""
    if not is_openai(client):
        return
    for place in (client.chat.completions, client.responses):
        if not hasattr(place.create, "checked"):
            place.create = _checked(place.create)  # type: ignore[method-assign]


def _checked(usual: Any) -> Any:
    from openai import APIStatusError, BadRequestError

    async def create(**request: Any) -> Any:
        try:
            came = await usual(**request)
        except APIStatusError as error:
            if said := _refusal_in(error):
                refused = {"code": REFUSED, "message": said}  # in the form that Inspect AI takes for a refusal
                raise BadRequestError(said, response=error.response, body=refused) from None
            raise
        return came if request.get("stream") else accepted(came)

    create.checked = True  # type: ignore[attr-defined]
    return create


def _refusal_in(error: APIStatusError) -> str:
    """The words of a status that refuses the conversation; empty for any other."""
    if error.status_code not in _REFUSING or not isinstance(said := error.body, Mapping):
        return ""
    words, more = str(said.get("message") or error.message), said.get("metadata")
    flagged = isinstance(more, Mapping) and bool(more.get("reasons"))
    named = _REFUSED_FOR.search(f"{said.get('code')} {said.get('type')}") or _REFUSED_IN_WORDS.search(words)
    return words if flagged or named else ""


def accepted(came: Any) -> Any:
    """An answer, straightened. What is no object is left to Inspect AI, which refuses it.

    Raises:
        Declined: If it holds no reply.
    """
    if not isinstance(came, BaseModel):
        return came
    _straighten_counts(came)
    if isinstance(output := getattr(came, "output", None), list):
        _check_output(came, output)
        return came
    if choices := getattr(came, "choices", None):
        _straighten(choices[0], came, _error_in(came, "error"))
        _forget_error(came)
        return came
    error = _error_in(came, "error", "errors", "detail", "message")
    if error is None:
        raise _nothing(came, "no reply in its answer")
    if not error.refused:
        raise Declined(error.words, error.status, usage=_usage_of(came))
    _refuse(came, error.words)
    _forget_error(came)
    return came


def _refuse(came: Any, words: str) -> None:
    """Put a refusal where the reply would be."""
    from openai.types.chat.chat_completion import Choice

    refusal = _empty_message()
    refusal.content, refusal.refusal = None, words
    came.choices = [Choice.model_construct(index=0, message=refusal, finish_reason=REFUSED, logprobs=None)]


def _empty_message() -> Any:
    from openai.types.chat import ChatCompletionMessage

    return ChatCompletionMessage.model_construct(role="assistant")


def _forget_error(came: Any) -> None:
    """Leave out an error that is none or was understood; Inspect AI raises some of them without a look."""
    if hasattr(came, "error"):
        came.error = None


class _Error(NamedTuple):
    words: str
    status: int | None
    refused: bool


def _error_in(holder: Any, *names: str) -> _Error | None:
    """The error under the first of these names; None if there is none."""
    said = next((said for name in names if (said := getattr(holder, name, None))), None)
    if isinstance(said, list):
        said = said[0]
    if said is None:
        return None
    parts = said if isinstance(said, dict) else getattr(said, "__dict__", {"code": getattr(holder, "code", None)})
    if isinstance(said, dict) and not any(said.values()):
        return None
    code, more = str(parts.get("code")), parts.get("metadata")
    flagged = isinstance(more, dict) and bool(more.get("reasons"))
    return _Error(
        words=str(parts.get("message") or said),
        status=int(code) if code in _FAILURES else None,
        refused=flagged or kind_of_stop(f"{code} {parts.get('type')}", empty=False) == "refusal",
    )


def _nothing(came: Any, words: str) -> Declined:
    """The fault of an answer without a reply, which may have been charged for."""
    return Declined(words, usage=_usage_of(came), charged=True)


def _check_output(came: Any, output: list[Any]) -> None:
    """Check an answer of the interface "responses"; a refusal is left to Inspect AI.

    Raises:
        Declined: If it holds no reply.
    """
    error = _error_in(came, "error")
    if error is not None and not error.refused:
        raise Declined(error.words, error.status, usage=_usage_of(came), charged=bool(output))
    status = str(getattr(came, "status", None) or "completed")
    cause = getattr(getattr(came, "incomplete_details", None), "reason", None)
    unfinished = status in _UNFINISHED or (status == "incomplete" and not cause)
    counted = _usage_of(came)
    unwritten = counted is not None and counted.input_tokens > 0 and counted.output_tokens == 0
    empty = status == "completed" and all(_is_empty(item, letterless=unwritten) for item in output)
    if error is None and (kind_of_stop(status, empty=False) == "fault" or unfinished or empty):
        raise _nothing(came, f"a reply {'that is not finished' if unfinished else 'without content'}, status {status}")


def _is_empty(item: Any, *, letterless: bool) -> bool:
    """Whether an item is a message without content; ``letterless``: or one whose content has no letter."""
    parts = getattr(item, "content", None)
    held = any(_entry(part, "text") or _entry(part, "refusal") for part in parts or ()) if letterless else bool(parts)
    return getattr(item, "type", "") == "message" and not held


def _straighten(choice: Any, came: Any, beside: _Error | None) -> None:
    """Give a choice one text or one refusal. ``beside`` is an error in the same answer.

    Raises:
        Declined: If it holds no reply.
    """
    message = getattr(choice, "message", None)
    said = _said(getattr(message, "content", None))
    refusal = _text_of(getattr(message, "refusal", None)) or said.refusal
    empty = not (said.text or "").strip()
    if error := _error_in(choice, "error") or beside:
        if not error.refused:
            raise Declined(error.words, error.status, usage=_usage_of(came), charged=not empty)
        refusal = refusal or error.words
    reasons = {name: str(getattr(choice, name, None) or "") for name in ("finish_reason", "native_finish_reason")}
    for name, reason in reasons.items():
        kind = kind_of_stop(reason, empty=empty) if reason else "reply"
        if kind == "refusal":
            refusal = refusal or f"{name} {reason}{'' if empty else f', after {said.text!r}'}"
        elif kind == "fault" and not refusal:
            raise Declined(f"{name} {reason}", usage=_usage_of(came), charged=not empty)
    cut_off = reasons["finish_reason"].lower() in _CUT_OFF
    called = any(getattr(message, name, None) for name in _CALLS)
    reasoned = said.reasoning or any(getattr(message, name, None) for name in _REASONING) or _reasoning_tokens(came)
    if empty and not (refusal or called or cut_off):
        _refuse_nothing(came, said, " ".join(filter(None, reasons.values())), reasoned=bool(reasoned))
    _write(choice, message, said, refusal)
    if cut_off:
        choice.finish_reason = "length"


class _Said(NamedTuple):
    """The content of a message by its kinds; ``text`` is None if there is none, which is not the same as no letter."""

    text: str | None
    refusal: str = ""
    reasoning: str = ""


def _refuse_nothing(came: Any, said: _Said, reason: str, *, reasoned: bool) -> None:
    """Let an empty reply pass only if a model can have given it.

    Raises:
        Declined: If it comes without a reason for its end, without a token, or without reasoning and content.
    """
    counted = _usage_of(came)
    if not reason:
        raise _nothing(came, "an empty reply without a reason for its end")
    if counted is not None and counted.input_tokens and not counted.output_tokens:
        raise _nothing(came, f"an empty reply of 0 tokens, {reason}")
    if said.text is None and not reasoned:
        raise _nothing(came, f"a reply without content (null), {reason}")


def _write(choice: Any, message: Any, said: _Said, refusal: str) -> None:
    """Put what was said in the place where Inspect AI looks for it."""
    if message is None:
        choice.message = message = _empty_message()
    message.content, message.refusal = (None, refusal) if refusal else (said.text, None)
    if refusal:
        choice.finish_reason = REFUSED
    if said.reasoning and not any(getattr(message, name, None) for name in _REASONING):
        message.reasoning_content = said.reasoning


def _said(content: Any) -> _Said:
    """Content as text, in parts, or as the object that was asked for. Parts are joined as they are."""
    if content is None or isinstance(content, str):
        return _Said(content)
    if isinstance(content, dict) and content.keys().isdisjoint({"type", "text"}):
        return _Said(json.dumps(content))
    if not isinstance(content, list | dict):
        return _Said(str(content))
    kinds: dict[str, list[str]] = {"text": [], "refusal": [], "reasoning": []}
    for part in content if isinstance(content, list) else [content]:
        kind = "text" if isinstance(part, str) else str(_entry(part, "type") or "text")
        kind = "reasoning" if kind in ("thinking", "reasoning", "reasoning_text") else kind.removeprefix("output_")
        if kind in kinds:
            names = (kind, "text", "thinking", "content", "summary")
            held = part if isinstance(part, str) else next((one for name in names if (one := _entry(part, name))), "")
            kinds[kind].append(_text_of(held))
    texts, refusals, thoughts = ("".join(kinds[kind]) for kind in ("text", "refusal", "reasoning"))
    return _Said(texts if kinds["text"] else None, refusals, thoughts)


def _entry(part: Any, name: str) -> Any:
    return part.get(name) if isinstance(part, Mapping) else getattr(part, name, None)


def _text_of(value: Any) -> str:
    """A text, or the texts in a list or an object that holds them."""
    if isinstance(value, list):
        return "".join(map(_text_of, value))
    if isinstance(value, Mapping):
        return _text_of(value.get("text") or value.get("value") or "")
    return value if isinstance(value, str) else "" if not value else str(value)


def _straighten_counts(came: Any) -> None:
    """Leave out a model name or token counts that the server got wrong."""
    if not isinstance(getattr(came, "model", None), str):
        came.model = ""
    if (usage := getattr(came, "usage", None)) is None:
        return
    read, written = _names(came)
    counts = [getattr(usage, f"{name}_tokens", None) for name in (read, written)]
    if not all(type(count) is int and count >= 0 for count in counts):
        came.usage = None
        return
    if type(getattr(usage, "total_tokens", None)) is not int:
        usage.total_tokens = sum(counts)
    for name, inner in ((read, "cached_tokens"), (written, "reasoning_tokens")):
        details = getattr(usage, f"{name}_tokens_details", None)
        if details is not None and type(getattr(details, inner, None)) not in (int, type(None)):
            setattr(usage, f"{name}_tokens_details", None)


def _names(came: Any) -> tuple[str, str]:
    """How the interface names what was read and what was written."""
    return ("input", "output") if hasattr(came, "output") else ("prompt", "completion")


def _usage_of(came: Any) -> Usage | None:
    """The tokens that an answer counts; None if it counts none."""
    if (usage := getattr(came, "usage", None)) is None:
        return None
    read, written = (getattr(usage, f"{name}_tokens") for name in _names(came))
    return Usage(input_tokens=read, output_tokens=written, reasoning_tokens=_reasoning_tokens(came))


def _reasoning_tokens(came: Any) -> int:
    details = getattr(getattr(came, "usage", None), f"{_names(came)[1]}_tokens_details", None)
    return getattr(details, "reasoning_tokens", None) or 0
