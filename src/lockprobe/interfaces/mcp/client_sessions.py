"""The sessions of clients over HTTP, capped: a client may go without ending its session.

A new session at the cap ends the one that has been unused for longest, so nobody is locked out. The client of that
session is told 404, connects anew, and goes on with the trial where it stands.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, MutableMapping
from dataclasses import dataclass
from typing import Any

from lockprobe.interfaces.mcp.tools import SESSION_HEADER

__all__ = ["MOST_SESSIONS", "App", "ClientSessions", "Message", "Receive", "Scope", "Send"]

MOST_SESSIONS = 64

_HEADER = SESSION_HEADER.encode()

Message = MutableMapping[str, Any]
Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]


@dataclass(slots=True)
class _Use:
    """What a session is being used for: calls being answered, and open streams of messages to the client.

    ``opening`` is the request that opened it.
    """

    opening: Scope
    calls: int = 0
    streams: int = 0


class ClientSessions:
    """An application whose sessions are capped.

    Args:
        app: The application, which gives each session its ID.
        playing: The session that plays a trial; empty for none.
        most: Open sessions in total.
    """

    def __init__(self, app: App, playing: Callable[[], str], most: int = MOST_SESSIONS) -> None:
        self._app, self._playing, self._most = app, playing, most
        self._open: dict[str, _Use] = {}
        """Longest unused first."""

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """One request."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        given = next((value.decode("latin-1") for name, value in scope["headers"] if name == _HEADER), "")
        begun = ""

        async def sent(message: Message) -> None:
            nonlocal begun
            if message["type"] == "http.response.start":
                begun = self._answered(scope, given, message)
            await send(message)

        use = self._use(scope, given)
        streams = scope["method"] == "GET"
        use.streams, use.calls = use.streams + streams, use.calls + (not streams)
        try:
            await self._app(scope, receive, sent)
        finally:
            use.streams, use.calls = use.streams - streams, use.calls - (not streams)
        if begun and len(self._open) > self._most:
            await self._end(self._least_needed(besides=begun))

    async def close(self) -> None:
        """End the sessions whose calls are answered, and with them the streams that would never end."""
        for session in [one for one, use in self._open.items() if not use.calls]:
            await self._end(session)

    def _use(self, scope: Scope, session: str) -> _Use:
        """The use of a session, which becomes the last used; a use that nobody looks at where there is none."""
        found = self._open.pop(session, None)
        if found is None:
            return _Use(scope)
        self._open[session] = found
        return found

    def _answered(self, scope: Scope, given: str, start: Message) -> str:
        """Keep account of a session that an answer begins or ends. Returns the one that it begins."""
        if given:
            if start["status"] == 404:
                self._open.pop(given, None)
            return ""
        begun = next((value.decode("latin-1") for name, value in start["headers"] if name.lower() == _HEADER), "")
        if not begun or start["status"] >= 400:
            return ""
        self._open[begun] = _Use(scope)
        return begun

    def _least_needed(self, *, besides: str) -> str:
        """The session to end: unused rather than in use, without a trial rather than with one; longest unused."""
        playing = self._playing()
        others = (one for one in self._open if one != besides)
        return min(others, key=lambda one: (self._open[one].calls > 0, one == playing, self._open[one].streams > 0))

    async def _end(self, session: str) -> None:
        """End a session as its client would have."""
        opening = self._open.pop(session).opening
        headers = [(name, value) for name, value in opening["headers"] if name == b"host"]
        asked = {**opening, "method": "DELETE", "headers": [*headers, (_HEADER, session.encode("latin-1"))]}
        await self._app(asked, _no_body, _ignore)


async def _no_body() -> Message:
    return {"type": "http.request", "body": b"", "more_body": False}


async def _ignore(message: Message) -> None:
    """Nobody waits for this answer."""
