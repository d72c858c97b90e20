"""A faster path through OpenAI's client: requests are sent unchanged, without its search through their types.

Before the client sends a conversation, it compares every part of every message with all types that the part could
have. It looks for names to translate and files to encode. Inspect AI hands it plain JSON, which holds neither. The
search costs more processor time than the rest of the call, and grows with every step of a trial.

The client has no switch for this (openai 3.52.0). Its README documents ``client.post`` for requests that it does not
know, and that method skips the search. So ``create`` is replaced by a function that posts. All providers that Inspect
AI reaches through this client gain; other clients stay as they are.

Without it, a study of a fast model waits for the processor rather than for its provider. ``lockprobe run`` of 210
trials with 20 calls each, report included, takes 22 s of processor time instead of 43 s or more (two runs of each
against a local server, Inspect AI 0.3.285, two cores with other work running, 2026-11-26). Of 20 trials it takes 9.2 s
instead of 10.0 s, most of it for the start and the report. ``benchmarks/openai_fast_path.py`` measures a call: 2.6 ms
instead of 5.2 ms.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from lockprobe.agents.llm.openai_client import is_openai

if TYPE_CHECKING:
    from openai import AsyncOpenAI
    from openai.resources.chat import AsyncCompletions
    from openai.resources.responses import AsyncResponses


def use_fast_path(client: object) -> None:
    """Make an OpenAI client send requests unchanged; leave other clients as they are."""
    if not is_openai(client):
        return
    from openai.types.chat import ChatCompletion
    from openai.types.responses import Response

    chat, responses = client.chat.completions, client.responses
    chat.create = _posting(client, "/chat/completions", ChatCompletion, chat)  # type: ignore[method-assign]
    responses.create = _posting(client, "/responses", Response, responses)  # type: ignore[method-assign]


def _posting(client: AsyncOpenAI, path: str, answer: type, usual: AsyncCompletions | AsyncResponses) -> Any:
    from openai import NotGiven, Omit

    created = usual.create

    async def create(**request: Any) -> Any:
        if request.get("stream") or not _KNOWN.isdisjoint(request):
            return await created(**request)
        headers = request.pop("extra_headers", None)
        body = {name: value for name, value in request.items() if not isinstance(value, NotGiven | Omit)}
        return await client.post(path, cast_to=answer, body=body, options={"headers": headers or {}})

    return create


_KNOWN = {"extra_body", "extra_query", "timeout"}
"""The arguments that the client's own method accepts with a request."""
