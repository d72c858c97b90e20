"""A pool of connections for every request on its way, so that a request costs the same however many there are.

The pool of httpx looks at all its connections whenever a request begins and whenever one ends, and asks the system
whether the idle ones are still open. With a hundred connections this costs as much processor time as the rest of HTTP.
Here every request takes a pool that no other request uses, so each pool has one connection. There are as many pools as
there ever were requests at once, and the one that was used last is taken first.
"""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable
from contextlib import ExitStack
from typing import Any

from lockprobe.agents.llm.inspect_internals import LoopScopedTransport

try:
    from httpx2 import AsyncBaseTransport, AsyncByteStream, Request, Response, create_ssl_context
except ImportError:  # another provider's package will do
    AsyncBaseTransport = AsyncByteStream = object  # type: ignore[assignment,misc]


def spread_connections(client: object) -> None:
    """Give a provider's client such pools, with the settings of its own; leave clients without Inspect AI's pool."""
    sending: Any = getattr(client, "_client", None)
    pool = getattr(sending, "_transport", None)
    if LoopScopedTransport is not None and isinstance(pool, LoopScopedTransport):
        sending._transport = _Spread(pool)  # noqa: SLF001 - a client of httpx offers no other way


class _Spread(AsyncBaseTransport):
    """Many pools like one, each for one request at a time."""

    def __init__(self, pool: Any) -> None:
        self._pools, self._free = [pool], [pool]
        self._settings: dict[str, Any] = {}

    async def handle_async_request(self, request: Request) -> Response:
        pool = self._free.pop() if self._free else self._another()
        with ExitStack() as back:
            back.callback(self._free.append, pool)
            response: Response = await pool.handle_async_request(request)
            back.pop_all()
        response.stream = _Lent(response.stream, lambda: self._free.append(pool))
        return response

    def _another(self) -> Any:
        first = self._pools[0]
        if not self._settings:  # certificates are read once, which takes longer than many requests
            self._settings = {"verify": create_ssl_context(), **first._kwargs}  # noqa: SLF001 - not public
        self._pools.append(type(first)(**self._settings))
        return self._pools[-1]

    async def aclose(self) -> None:
        for pool in self._pools:
            await pool.aclose()


class _Lent(AsyncByteStream):
    """The body of a response, which gives its pool back when it is closed."""

    def __init__(self, body: Any, give_back: Callable[[], None]) -> None:
        self._body, self._give_back = body, give_back
        self._closed = False

    def __aiter__(self) -> AsyncIterator[bytes]:
        body: AsyncIterator[bytes] = aiter(self._body)
        return body

    async def aclose(self) -> None:
        if self._closed:
            return
        self._closed = True
        try:
            await self._body.aclose()
        finally:
            self._give_back()
