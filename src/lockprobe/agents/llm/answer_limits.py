"""Checks a provider's answers: they come from the host that was asked, with a limited size.

A redirect to another origin would send the whole conversation there, and an endless answer would fill the memory. Both
are refused for providers that use a client of httpx: OpenAI, Anthropic, Groq and all with OpenAI's interface.
"""

from __future__ import annotations

from typing import Any

from lockprobe.agents.llm.retry import RefusedReply

LARGEST_ANSWER = 1 << 24
"""The most bytes of a decompressed answer: 16 MiB. Typical answers have a few thousand."""

_PACKED = ("gzip", "deflate")
"""The allowed compressions of an answer. Others decompress so much at once that no limit would help."""

_PORTS = {"http": 80, "https": 443}


def guard_answers(client: object) -> None:
    """Make a provider's client refuse such answers; leave clients without httpx unchanged."""
    for place in (client, getattr(client, "_client", None)):
        hooks = getattr(place, "event_hooks", None)
        if isinstance(hooks, dict) and hasattr(place, "headers"):
            sending: Any = place
            sending.headers["accept-encoding"] = ", ".join(_PACKED)
            sending.event_hooks = {**hooks, "response": [_check, *hooks.get("response", [])]}


async def _check(response: Any) -> None:
    """Called with every response before its body is read, and before a redirect is followed.

    Raises:
        RefusedReply: If it leads elsewhere, or is too large.
    """
    if response.has_redirect_location:
        here, there = response.request.url, response.request.url.join(response.headers["location"])
        if _origin(here) != _origin(there):
            raise RefusedReply(
                f"a redirect from {_named(here)} to {_named(there)}, which must not get the conversation"
            )
    packed = response.headers.get("content-encoding", "identity").lower()
    if not {part.strip() for part in packed.split(",")} <= {"identity", *_PACKED}:
        raise RefusedReply(f"an answer compressed with {packed[:40]}, which was not requested", charged=True)
    parts, size = [], 0
    async for part in response.aiter_bytes():
        parts.append(part)
        size += len(part)
        if size > LARGEST_ANSWER:
            raise RefusedReply(f"an answer of more than {LARGEST_ANSWER} bytes", charged=True)
    response._content = b"".join(parts)  # noqa: SLF001 - as its own aread() leaves it


def _origin(url: Any) -> tuple[str, str, int | None]:
    return url.scheme, url.host, url.port or _PORTS.get(url.scheme)


def _named(url: Any) -> str:
    return f"{url.scheme}://{url.netloc.decode('ascii', 'replace').rpartition('@')[2]}"
