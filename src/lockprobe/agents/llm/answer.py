"""What a server answers: a reply of the model, a refusal, or a fault of the server.

A refusal is a finding about the model: its trial ends, and nobody asks again. A fault says nothing about the model: the
request is made again after a pause, and the trial is owed. Servers send faults with any status: in place of the reply,
beside it, inside the choice, or as the reason for its end. ``tests/agents/llm/test_replies.py`` has a row for every
shape of an answer that was seen.
"""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Mapping
from contextlib import suppress
from dataclasses import replace
from typing import Any

from lockprobe.agents.reply import REFUSED
from lockprobe.foundation.redaction import without_keys, without_secrets
from lockprobe.foundation.terminal_text import printable
from lockprobe.trial.model_call import Call, Usage

MENDING = "; to mend it, "
"""Stands in the error of a call between what was said and what has to be done before the same request can succeed."""

LONGEST_REPLY, _LONGEST_SAID = 100_000, 400
"""The most characters kept of a reply, which typically has a few hundred, and of a provider's message."""

_REFUSAL = re.compile(
    r"content.?filter|refus|safety|recitation|prohibited|block|spii|sensitive|guardrail|moderat|policy|toxic|flagged"
    r"|model.?armor|invalid.?prompt",
    re.IGNORECASE,
)
_FAULT = re.compile(
    r"error|fail|network|context|abort|cancel|time.?out|timed|unavailable|overload|interrupt|insufficient|malformed|disconnect",
    re.IGNORECASE,
)
"""How servers name the reasons for an end that is neither the model's nor the limit's."""

_NO_REASON = ("", "other", "unknown", "unspecified", "finish_reason_unspecified", "none", "null")

_REASONS = ("finish_reason", "native_finish_reason")

_REFUSED_FOR = re.compile(
    r"content.?(?:filter|policy|risk)|safety|moderation|flagged|invalid.?prompt|data.?inspection|prohibited",
    re.IGNORECASE,
)
_REFUSED_IN_WORDS = re.compile(r"content exists risk|inappropriate content|requires moderation", re.IGNORECASE)
"""How the code or type of an error names a refusal; few services say it in words alone."""

_MENDING = {
    "give it a larger context, or the trials fewer steps": (
        r"^(?!.*answered 429).*(?:context.?(?:length|window).?exceeded|maximum context length"
        r"|exceed\w* (?:the )?(?:available )?context|(?:prompt|input) is too long|input token count .* exceeds)"
    ),
    "raise the quota or top up the account": (
        r"answered 402|insufficient_quota|credit balance|(?!.*retry in \d)(?:exceeded your current quota|billing)"
    ),
    "wait until its daily limit is renewed, or raise it": r"per.?day|daily|\b[RT]PD\b",
    "ask for the form of the reply in words, with the option schema=none": (
        r"response.?format|json.?schema|structured.?output|output_config|guided|grammar"
    ),
    "leave that option out of the spec": (
        r"(?=.*(?:unsupported|not supported|unrecogni[sz]ed|unknown|not permitted|no endpoints found that))"
        r".*(?:param|argument|temperature|top_p|effort|reasoning|thinking|max\w*_tokens)"
    ),
}
"""What mends an error that no later attempt does, and what such an error says."""

_ERROR_PAGE = re.compile(
    r"\W*(?:<!doctype html|<html|(?:http |error:? )*5\d\d:? (?:internal|bad|service|gateway)"
    r"|internal server error|bad gateway|gateway time-?out"
    r"|upstream (?:connect )?error|service (?:is )?(?:temporarily |currently )?unavailable|too many requests"
    r"|(?:the )?(?:server|model|service) is (?:currently |temporarily )?(?:overloaded|busy|unavailable|loading))",
    re.IGNORECASE,
)
"""How texts begin that a gateway writes in the place of a reply."""

CUT_OFF = "max_tokens"
"""Why a reply stopped that reached its limit."""

_STOPS = {
    **dict.fromkeys(("stop", "end_turn", "stop_sequence", "eos", "complete"), "stop"),
    **dict.fromkeys(("length", "max_tokens", "max_output_tokens"), CUT_OFF),
    **dict.fromkeys(("tool_calls", "function_call", "tool_use"), "tool_calls"),
}
"""How servers name the reason for the end of a reply, in small letters, and how a call does."""

IN_REASONING = "in_reasoning"
"""Why a reply is empty if the object that was asked for stands in the reasoning."""


class NoReply(Exception):
    """An attempt to which no reply came.

    Args:
        words: What is said of it; secrets are left out.
        status: The status of the answer, or the one that it says; 200 for an error in the place of a reply, None if
            nothing came that the provider said.
        again: Whether the same request may succeed later; never if the words say that something has to be mended.
        charged: Whether it may be charged for, although nobody counted it.

    Attributes:
        usage: What the server counted for it, if it counted anything.
        wait: Seconds that the server asks to wait; None if it says nothing.
    """

    def __init__(self, words: str, *, status: int | None = None, again: bool = True, charged: bool = False) -> None:
        if status is not None:
            words = f"the provider answered {'with an error' if status < 300 else status}: {words}"
            again = again and (status < 300 or status in (408, 409, 425, 429) or status >= 500)
        remedy = next((remedy for remedy, said in _MENDING.items() if re.search(said, words, re.IGNORECASE)), "")
        super().__init__(f"{words}{MENDING}{remedy}" if remedy else words)
        self.again = again and not remedy
        self.charged = charged or status in (504, 524)  # a gateway gave up, and the server may have gone on
        self.usage = Usage()
        self.wait: float | None = None


def read_answer(
    asked: Call, seconds: float, status: int, headers: Mapping[str, str], content: bytes, names: Collection[str] = ()
) -> Call:
    """The call with the reply in an answer, of a refusal with its words, and with what it and failed attempts cost.

    ``names`` are the fields of the object that a schema asks for; where it stands in the reasoning, nothing else comes.

    Raises:
        NoReply: If it holds none.
    """
    if 300 <= status < 400:
        there = f"it sends the conversation to {_line(headers.get('location', 'elsewhere'))}"
        raise NoReply(f"{there}{MENDING}name that server", status=status)
    whole = content.decode("utf-8-sig", "replace")
    if (came := _object(whole)) is None:
        if status < 400:
            raise NoReply(f"a reply that cannot be read ({_line(whole)})", charged=True)
        came = {"error": whole}
    if "stop_reason" in came:
        came = _of_messages(came)
    usage = (None if status >= 400 else _usage(came)) or Usage(calls=1)
    try:
        text, stop, thoughts = _read(came, status, usage)
    except NoReply as none:
        wait = re.fullmatch(r"\d{1,9}(\.\d*)?", headers.get("retry-after", ""))
        none.usage, none.wait = replace(usage, calls=0), float(wait[0]) if wait else None
        raise
    if names and not text.strip():
        last = _object(thoughts[thoughts.rfind("{") :]) or {}
        stop = IN_REASONING if last.keys() >= set(names) else stop
    model, provider, version = (
        said if isinstance(said := came.get(name), str) else "" for name in ("model", "provider", "system_fingerprint")
    )
    served = ", ".join(filter(None, (f"{model} by {provider}" if provider else model, version)))
    lost, counted = asked.usage != Usage(), bool(usage.input_tokens or usage.output_tokens)
    return replace(
        asked,
        reply=without_keys(text)[:LONGEST_REPLY],
        stop=stop,
        served=printable(without_keys(served))[:200],
        usage=usage + asked.usage if lost else usage,
        seconds=seconds,
        unanswered=asked.unanswered + (lost and not counted),  # the sum would hide it
        reasoned=bool(thoughts),
    )


def _read(came: Mapping[str, Any], status: int, counted: Usage) -> tuple[str, str, str]:
    """Text, reason for its end, and reasoning."""
    choices = came.get("choices")
    if status >= 400 or not isinstance(choices, list) or not choices:
        if refusal := _refusal_in(came, "error", "errors", "detail", "message", status=status):
            return refusal, REFUSED, ""
        why = "no error is named" if status >= 400 else "no reply in its answer"
        raise NoReply(why, status=status, charged=status < 400)
    choice = _mapping(choices[0])
    message = _mapping(choice.get("message"))
    said, refusal, thoughts = _said(message.get("content"))
    text = said or ""
    if refusal := _refused(choice, came, text, _text_of(message.get("refusal")) or refusal):
        return refusal, REFUSED, thoughts
    stop = _STOPS.get(str(choice.get("finish_reason")).lower(), "unknown")
    names = ("reasoning", "reasoning_content", "reasoning_details")
    thoughts = thoughts or next((_text_of(message[name]) or "…" for name in names if message.get(name)), "")
    if text.strip():
        thought_alone = "</think>" in text and not text.rpartition("</think>")[2].strip()
        return text, stop, thoughts or (text if thought_alone else "")
    if message.get("tool_calls") or message.get("function_call"):
        return "", "tool_calls", thoughts
    # no model gives an empty reply without a token, a thought or a reason for its end
    nothing = not counted.output_tokens or (said is None and not counted.reasoning_tokens)
    reason = " ".join(str(choice[name]) for name in _REASONS if choice.get(name))
    if stop != CUT_OFF and (not reason or (nothing and not thoughts)):
        reason = reason or "without a reason for its end"
        raise NoReply(f"an empty reply that no model gives, {reason}", status=200, charged=True)
    return text, stop, thoughts


def _refused(choice: Mapping[str, Any], came: Mapping[str, Any], text: str, refusal: str) -> str:
    """The words of a refusal, as such, beside a text or in its place; empty for a reply, and a fault is raised."""
    empty = not text.strip()
    error = _refusal_in(choice, "error", charged=not empty) or _refusal_in(came, "error", charged=not empty)
    if refusal := refusal or error:
        return refusal
    reasons = [(name, str(choice[name])) for name in _REASONS if choice.get(name)]
    for name, reason in reasons:
        if _REFUSAL.search(reason):
            return f"{name} {reason}" if empty else f"{name} {reason}, after {text!r}"
    for name, reason in reasons:
        if _FAULT.search(reason) or (empty and reason.lower() in _NO_REASON):
            raise NoReply(f"{name} {reason}", status=200, charged=not empty)
    if "{" not in text and len(text) < _LONGEST_SAID and _ERROR_PAGE.match(text):
        raise NoReply(_line(text), status=200, charged=True)
    if text.lstrip().startswith("{") and '"error"' in text and '"joint"' not in text:
        return _refusal_in(_object(text) or {}, "error", charged=True)
    return ""


def _refusal_in(holder: Mapping[str, Any], *names: str, status: int = 200, charged: bool = False) -> str:
    """The words of the error under the first of these names if it refuses the conversation; empty without an error.

    Raises:
        NoReply: If it is about the account, the request or the server. Its status may be its code.
    """
    said = next((said for name in names if (said := holder.get(name))), None)
    said = said[0] if isinstance(said, list) else said
    if said is None or (isinstance(said, dict) and not any(said.values())):
        return ""
    parts = said if isinstance(said, dict) else {name: holder.get(name) for name in ("code", "type")}
    words, named = _line(str(parts.get("message") or said)), f"{parts.get('code')} {parts.get('type')}"
    flagged = _mapping(parts.get("metadata")).get("reasons") or _REFUSED_FOR.search(named)
    if (flagged or _REFUSED_IN_WORDS.search(words)) and status in (200, 400, 403, 422, 451):
        return words
    if (why := re.search("insufficient_quota|context_length_exceeded", named)) and why[0] not in words:
        words = f"{words} ({why[0]})"  # which says what mends it, whatever the words are
    code = re.match("[45][0-9][0-9] ", named) if status < 300 else None
    raise NoReply(words, status=int(code[0]) if code else status, charged=charged)


def _of_messages(came: Mapping[str, Any]) -> dict[str, Any]:
    """An answer of Anthropic's interface in the form of chat completions."""
    counts, details, stop = _mapping(came.get("usage")), _mapping(came.get("stop_details")), came.get("stop_reason")
    names = ("input_tokens", "cache_read_input_tokens", "cache_creation_input_tokens", "output_tokens")
    fresh, cached, stored, written = (counts.get(name) or 0 for name in names)
    why = ": ".join(str(details[name]) for name in ("category", "explanation") if details.get(name))
    usage: dict[str, Any] = {}
    if counts and all(type(number) is int for number in (fresh, cached, stored, written)):
        usage = {"prompt_tokens": fresh + cached + stored, "completion_tokens": written}
        usage["prompt_tokens_details"] = {"cached_tokens": cached, "cache_write_tokens": stored}
    message = {"content": came.get("content"), "refusal": why if stop == "refusal" else ""}
    reason = "interrupted" if stop == "pause_turn" else stop
    return {**came, "choices": [{"message": message, "finish_reason": reason}], "usage": usage}


def _said(content: object) -> tuple[str | None, str, str]:
    """Text, refusal and reasoning in a content; the text is None if there is none, which is not the same as no letter.

    It comes as text, in parts, or as the object that was asked for. Parts are joined: they are chunks, not lines.
    """
    if isinstance(content, dict) and content.keys().isdisjoint({"type", "text"}):
        return json.dumps(content), "", ""
    kinds: dict[str, str] = {}
    for part in content if isinstance(content, list) else [] if content is None else [content]:
        of = part if isinstance(part, Mapping) else {"text": part}
        kind = str(of.get("type") or "text").removeprefix("output_")
        kind = "reasoning" if kind in ("thinking", "reasoning", "reasoning_text", "redacted_thinking") else kind
        names = (kind, "text", "thinking", "content", "summary", "data")
        kinds[kind] = kinds.get(kind, "") + _text_of(next((held for name in names if (held := of.get(name))), ""))
    return kinds.get("text"), kinds.get("refusal", ""), kinds.get("reasoning", "")


def _text_of(value: object) -> str:
    """A text, or the texts in a list or an object that holds them."""
    if isinstance(value, list):
        return "".join(map(_text_of, value))
    if isinstance(value, Mapping):
        return _text_of(value.get("text"))
    return value if isinstance(value, str) else "" if not value else str(value)


def _usage(came: Mapping[str, Any]) -> Usage | None:
    """The cost of an answer by its server's counts; None if one of them is missing or cannot be."""
    counts = _mapping(came.get("usage"))
    read, written, total = (counts.get(f"{name}_tokens") for name in ("prompt", "completion", "total"))
    if not (type(read) is int and type(written) is int):
        return None
    if type(total) is int:
        written = max(written, total - read)  # xAI leaves out those of reasoning
    of_read, of_written = (_mapping(counts.get(f"{name}_tokens_details")) for name in ("prompt", "completion"))
    said = (of_read.get("cached_tokens"), of_read.get("cache_write_tokens"), of_written.get("reasoning_tokens"))
    cached, stored, reasoned = (number if type(number) is int else 0 for number in said)
    numbers = (read, written, cached, stored, reasoned)
    if cached + stored > read or not all(0 <= number < 2**40 for number in numbers):
        return None
    names = ("input_tokens", "output_tokens", "cached_tokens", "stored_tokens", "reasoning_tokens")
    return Usage(calls=1, **dict(zip(names, numbers, strict=True)))


def _object(text: str) -> dict[str, Any] | None:
    """The JSON object that a text is; None if it is none."""
    with suppress(ValueError, RecursionError):
        return found if isinstance(found := json.loads(text), dict) else None
    return None


def _mapping(value: object) -> Mapping[str, Any]:
    return value if isinstance(value, Mapping) else {}


def _line(words: str) -> str:
    """A provider's words on one line, without secrets, which are looked for before any is cut in two."""
    return " ".join(without_secrets(words).split())[:_LONGEST_SAID]
