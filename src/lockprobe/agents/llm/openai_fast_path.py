"""Requests go to OpenAI's client as they are.

Before it sends a conversation, the client holds every part of every message against all types that the part could
have, looking for names to translate and files to encode. What Inspect AI hands it is JSON already and holds neither,
and the search costs more processor time than all the rest of a request, more with every step of a trial (figures in
``benchmarks/README.md``). So it is told to send what it is given, by the method that its README has for requests that
it does not know. All providers that Inspect AI reaches through this client gain; others are left alone.

Some servers send an error where the reply should be, with status 200; the client takes that for a reply without
anything in it. It is raised here, while the server's words are still there. Others leave out which model replied, or
what it counted; that costs a study no reply.
"""

from __future__ import annotations

from typing import Any

from lockprobe.agents.llm.retry import Declined

try:
    from openai import AsyncOpenAI, NotGiven, Omit
    from openai.resources.chat import AsyncCompletions
    from openai.resources.responses import AsyncResponses
    from openai.types.chat import ChatCompletion
    from openai.types.responses import Response
except ImportError:  # another provider's package will do
    AsyncOpenAI = None  # type: ignore[assignment,misc]

__all__ = ["send_plainly"]


def send_plainly(client: object) -> None:
    """Have a client of OpenAI's send requests as they are; leave any other as it is.

    Args:
        client: The client of a provider.
    """
    if AsyncOpenAI is None or not isinstance(client, AsyncOpenAI):
        return
    chat, responses = client.chat.completions, client.responses
    chat.create = _posting(client, "/chat/completions", ChatCompletion, chat)  # type: ignore[method-assign]
    responses.create = _posting(client, "/responses", Response, responses)  # type: ignore[method-assign]


def _posting(client: AsyncOpenAI, path: str, answer: type, usual: AsyncCompletions | AsyncResponses) -> Any:
    created = usual.create

    async def create(**request: Any) -> Any:
        if request.get("stream"):
            return await created(**request)
        if not _KNOWN.isdisjoint(request):
            return _accepted(await created(**request))
        headers = request.pop("extra_headers", None)
        body = {name: value for name, value in request.items() if not isinstance(value, NotGiven | Omit)}
        return _accepted(await client.post(path, cast_to=answer, body=body, options={"headers": headers or {}}))

    return create


def _accepted(came: Any) -> Any:
    """What came, unless it is an error in place of a reply.

    Raises:
        Declined: If it is.
    """
    if getattr(came, "choices", None) or getattr(came, "output", None):
        return _usable(came)
    error = next((said for name in ("error", "detail", "message") if (said := getattr(came, name, None))), None)
    if error is None:
        return came
    parts = error if isinstance(error, dict) else getattr(error, "__dict__", {"code": getattr(came, "code", None)})
    code = str(parts.get("code"))
    raise Declined(str(parts.get("message") or error), int(code) if code in _FAILURES else None)


def _usable(came: Any) -> Any:
    """A reply whose server says not or wrongly which model it is, or what it counted: it says neither then."""
    if not isinstance(getattr(came, "model", None), str):
        came.model = ""
    if (usage := getattr(came, "usage", None)) is None:
        return came
    read, written = ("prompt", "completion") if hasattr(came, "choices") else ("input", "output")
    counts = [getattr(usage, f"{name}_tokens", None) for name in (read, written)]
    if not all(type(count) is int and count >= 0 for count in counts):
        came.usage = None
        return came
    if type(getattr(usage, "total_tokens", None)) is not int:
        usage.total_tokens = sum(counts)
    for name, inner in ((read, "cached_tokens"), (written, "reasoning_tokens")):
        details = getattr(usage, f"{name}_tokens_details", None)
        if details is not None and type(getattr(details, inner, None)) not in (int, type(None)):
            setattr(usage, f"{name}_tokens_details", None)
    return came


_FAILURES = frozenset(map(str, range(400, 600)))
"""Codes that are statuses; some servers write them as text, and most codes are words."""


_KNOWN = {"extra_body", "extra_query", "timeout"}
"""What the client's own method takes beside a request."""
