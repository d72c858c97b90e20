"""Tells the answers of providers apart: a reply, a refusal, or a fault of the provider.

A refusal is a finding about the model: its trial ends, and nobody asks again. A fault says nothing about the model:
the request is made again after a pause, and the trial is owed.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, Literal

from lockprobe.agents.llm.retry import Declined, Tries, fault
from lockprobe.agents.prompt import REFUSED
from lockprobe.foundation.errors import needing
from lockprobe.trial.model_call import Usage

with needing("hosted models", "providers"):
    from inspect_ai.model import ChatCompletionChoice, ModelOutput, StopDetails

_MOST_COUNTED = 2**40

_REFUSAL = re.compile(
    r"content.?filter|refus|safety|recitation|prohibited|block|spii|sensitive|guardrail|moderat|policy|toxic|flagged"
    r"|model.?armor|invalid.?prompt",
    re.IGNORECASE,
)
_FAULT = re.compile(
    r"error|fail|network|abort|cancel|time.?out|timed|unavailable|overload|interrupt|insufficient|malformed|disconnect",
    re.IGNORECASE,
)
"""How providers name the reasons for an end that is neither the model's nor the limit's."""

_NO_REASON = ("", "other", "unknown", "unspecified", "finish_reason_unspecified", "none", "null")

_NOTHING_CAME = ("(no content)", "I seem to have had trouble calling a function")
"""How texts begin that Inspect AI writes in the place of a reply that did not come."""

_REASONS = ("finish_reason", "finishReason", "stop_reason", "stopReason")
"""How providers name the reason for the end of a reply."""

_ONCE = Tries()


def kind_of_stop(reason: str, *, empty: bool) -> Literal["reply", "refusal", "fault"]:
    """The kind of an answer by the provider's reason for its end; ``empty``: there is no text.

    >>> kind_of_stop("PROHIBITED_CONTENT", empty=True), kind_of_stop("network_error", empty=True)
    ('refusal', 'fault')
    >>> kind_of_stop("end_turn", empty=True), kind_of_stop("OTHER", empty=True), kind_of_stop("OTHER", empty=False)
    ('reply', 'fault', 'reply')
    """
    if _REFUSAL.search(reason):
        return "refusal"
    return "fault" if _FAULT.search(reason) or (empty and reason.lower() in _NO_REASON) else "reply"


def said_in(output: ModelOutput, body: object = None) -> tuple[str, str]:
    """The text of a reply and why it stopped, as Inspect AI names it; of a refusal its words and :data:`REFUSED`.

    Parts of a text are joined as they are: they are chunks, not lines. ``body`` is the answer as the provider sent it,
    where that is known; it holds reasons that Inspect AI leaves out.

    Raises:
        Declined: If the provider sent no reply.
    """
    counted = usage_of(output) if output.usage is not None else None
    if not output.choices:
        raise Declined("no reply in its answer", usage=counted, charged=True)
    choice, stop = output.choices[0], output.choices[0].stop_reason
    text, refusal = _texts(choice)
    if refusal or stop == REFUSED:
        return _words(choice, text, refusal or output.error or "") or _reason_in(body) or REFUSED, REFUSED
    said = text.strip()
    for name, reason in _reasons(body).items():
        kind = kind_of_stop(reason, empty=not said)
        if kind == "refusal":
            return f"{name} {reason}", REFUSED
        if kind == "fault":
            raise Declined(f"{name} {reason}", usage=counted, charged=True)
    if stop in ("unknown", "stop") and (said.startswith(_NOTHING_CAME) or (stop == "unknown" and not said)):
        raise Declined(f"an empty reply, {_reason_in(body) or 'without a reason'}", usage=counted, charged=True)
    if stop == "stop" and not said and _without_content(body) and not (counted and counted.reasoning_tokens):
        raise Declined(f"a reply without content, {_reason_in(body)}", usage=counted, charged=True)
    return text, stop


def reasoned_in(output: ModelOutput) -> bool:
    """Whether reasoning came with a reply, apart from its text; Inspect AI takes a closed ``<think>`` out of it."""
    content = output.choices[0].message.content if output.choices else ""
    return not isinstance(content, str) and any(part.type == "reasoning" for part in content)


def _texts(choice: ChatCompletionChoice) -> tuple[str, str]:
    """What the model said, and its refusal in words."""
    content = choice.message.content
    if isinstance(content, str):
        return content, ""
    parts = [part for part in content if part.type == "text"]
    return tuple("".join(part.text for part in parts if bool(part.refusal) is of) for of in (False, True))  # type: ignore[return-value]


def _words(choice: ChatCompletionChoice, text: str, refusal: str) -> str:
    """A refusal in the provider's words, with its reasons."""
    details = choice.stop_details or StopDetails()
    named = [details.type or "", *(f"{one.category} {one.level or ''}".strip() for one in details.categories)]
    reasons = [reason for reason in dict.fromkeys(named) if reason not in ("", "refusal", REFUSED)]
    said = refusal or details.explanation or ""
    return ": ".join(filter(None, (", ".join(reasons), said)))


def _candidate(body: object) -> Mapping[str, Any]:
    """The part of an answer that holds the reply and the reason for its end."""
    if not isinstance(body, Mapping):
        return {}
    listed = body.get("candidates") or body.get("choices")
    first = listed[0] if isinstance(listed, list) and listed else body
    return first if isinstance(first, Mapping) else {}


def _reasons(body: object) -> dict[str, str]:
    """The reasons for the end of a reply in the provider's words, by their names."""
    found = _candidate(body)
    return {name: str(found[name]).rpartition(".")[2] for name in _REASONS if found.get(name)}


def _reason_in(body: object) -> str:
    """The reasons on one line, and the provider's message about them; empty if it gives none."""
    found = _candidate(body)
    messages = (str(found[name]) for name in ("finishMessage", "finish_message") if found.get(name))
    return ", ".join((*(f"{name} {reason}" for name, reason in _reasons(body).items()), *messages))


def _without_content(body: object) -> bool:
    """Whether the place of the reply is there and holds nothing."""
    found = _candidate(body)
    return "finishReason" in found and found.get("content") is None  # Google's


def refuse_overflow(output: ModelOutput, tries: Tries = _ONCE) -> None:
    """Refuse the reply that Inspect AI substitutes for the provider's error about a conversation that is too long.

    Raises:
        ModelFault: If that is what came.
    """
    if not output.choices or output.stop_reason != "model_length":
        return
    counted = output.usage is not None
    said = "" if counted else f": {' '.join(output.completion.split())}"
    spent = usage_of(output) if counted else Usage()
    raise fault(f"the conversation is longer than the model can read{said}", tries, spent)


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
