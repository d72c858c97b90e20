"""Limits on connections: slow ones are closed, and their number is capped.

uvicorn limits the time between two requests and the size of a head, but not the time until a head is complete. Its
``limit_concurrency`` counts idle connections, which alone can lock everybody else out. Here a new connection at the
cap replaces the one that has waited longest for a request. If every other one is being answered, it gets 503.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

from uvicorn.config import Config
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.server import ServerState

from lockprobe.foundation.http_server.listening import is_loopback

FILES_KEPT_BACK = 256
"""Open files that connections leave to diaries, pictures and plants."""

_MOST_FILES = 65_536
"""The highest limit requested."""

_REFUSED_AT_ONCE = 64
"""The most connections that get 503 at the same time; more are closed without an answer."""

_BODY = b'{"error": "full", "message": "too many connections at once; try again"}'

FULL = (
    b"HTTP/1.1 503 Service Unavailable\r\ncontent-type: application/json\r\nretry-after: 2\r\n"
    b"connection: close\r\ncontent-length: " + str(len(_BODY)).encode() + b"\r\n\r\n" + _BODY
)
"""The answer to a connection without a place."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ConnectionLimits:
    """Limits on connections.

    Attributes:
        most: Open connections in total.
        each: Open connections per address. A browser opens up to six, so about forty behind one router fit.
            Connections from this machine do not count: a proxy makes them.
        head: Seconds for a request to arrive after its connection opened, or after its first byte.
        idle: Seconds for which a connection stays open after an answer.
        refused: Seconds for which a connection that got 503 stays open, so that the answer is read.
    """

    most: int = 1000
    each: int = 256
    head: float = 10.0
    idle: float = 30.0
    refused: float = 2.0

    def within(self, files: int | None) -> ConnectionLimits:
        """The same for a process that can open this many files; None for no limit."""
        if files is None:
            return self
        return replace(self, most=min(self.most, max(files - FILES_KEPT_BACK, files // 2, 1)))


def raise_file_limit() -> int | None:
    """Raise the soft limit on open files to the hard one. Returns the limit; None where there is none."""
    try:
        import resource
    except ImportError:  # Windows
        return None
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = _MOST_FILES if hard == resource.RLIM_INFINITY else min(hard, _MOST_FILES)
    if soft != resource.RLIM_INFINITY and soft < wanted:
        with suppress(OSError, ValueError):
            resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))
    soft, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return None if soft == resource.RLIM_INFINITY else soft


class Connections:
    """The open connections of a server.

    Args:
        limits: Limits on them.
        say: Gets one line for each connection that is refused.
        proxied: Whether addresses are not counted: a proxy hides them.
    """

    def __init__(self, limits: ConnectionLimits, say: Callable[[str], None], *, proxied: bool = False) -> None:
        self.limits = limits
        self.say, self._proxied = say, proxied
        self._open: dict[Connection, None] = {}
        """Longest waiting first."""
        self._by_address: dict[str, dict[Connection, None]] = {}
        self._refused: set[Connection] = set()
        self._ended = False

    def __len__(self) -> int:
        return len(self._open)

    def protocol(
        self,
        config: Config,
        server_state: ServerState,
        app_state: dict[str, Any],
        _loop: asyncio.AbstractEventLoop | None = None,
    ) -> Connection:
        """One connection, as uvicorn makes it."""
        return Connection(self, config, server_state, app_state, _loop)

    def admit(self, one: Connection) -> bool:
        """Give a new connection a place; at the cap, the place of the longest waiting one."""
        address = self._address(one)
        theirs = self._by_address.get(address, {})
        if self._ended:
            return False
        if len(theirs) >= self.limits.each and not self._make_room(theirs):
            return False
        if len(self._open) >= self.limits.most and not self._make_room(self._open):
            return False
        self._open[one] = None
        if address:
            self._by_address.setdefault(address, {})[one] = None
        return True

    def refuse(self, one: Connection) -> bool:
        """Whether a connection without a place can still be told so."""
        if not self._ended:
            self.say("503 full no place for another connection")
        if self._ended or len(self._refused) >= _REFUSED_AT_ONCE:
            return False
        self._refused.add(one)
        return True

    def end(self) -> None:
        """Admit no connection any more: the server is stopping."""
        self._ended = True

    def answered(self, one: Connection) -> None:
        """Move a connection to the end of the queue: it has just been answered."""
        for group in (self._open, self._by_address.get(self._address(one), {})):
            if one in group:
                del group[one]
                group[one] = None

    def remove(self, one: Connection) -> None:
        """Forget a closed connection."""
        self._open.pop(one, None)
        self._refused.discard(one)
        address = self._address(one)
        theirs = self._by_address.get(address, {})
        theirs.pop(one, None)
        if not theirs:
            self._by_address.pop(address, None)

    def _make_room(self, group: dict[Connection, None]) -> bool:
        """Close the longest waiting connection of a group, preferably one that never sent a request."""
        waiting = [one for one in group if one.waits]
        found = next((one for one in waiting if one.cycle is None), waiting[0] if waiting else None)
        if found is None:
            return False
        self.remove(found)
        found.transport.abort()
        return True

    def _address(self, one: Connection) -> str:
        """The address that a connection counts for; empty where addresses are not counted."""
        host = one.client[0] if one.client else ""
        return "" if self._proxied or is_loopback(host) else host


class Connection(H11Protocol):
    """One connection, which is closed if it keeps the server waiting."""

    def __init__(
        self,
        all_of_them: Connections,
        config: Config,
        server_state: ServerState,
        app_state: dict[str, Any],
        _loop: asyncio.AbstractEventLoop | None = None,
    ) -> None:
        super().__init__(config, server_state, app_state, _loop)
        self._all, self._refused, self._head_begun = all_of_them, False, True
        self._deadline: asyncio.TimerHandle | None = None

    @property
    def waits(self) -> bool:
        """Whether the server waits for a request, for the rest of one, or for an answer to be read."""
        cycle = self.cycle
        return cycle is None or cycle.response_complete or cycle.more_body or self.flow.write_paused

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override] # as in the base
        """The connection gets a place, or 503."""
        super().connection_made(transport)
        if self._all.admit(self):
            self._close_in(self._all.limits.head)
            return
        self._refused = True
        if not self._all.refuse(self):
            transport.abort()
            return
        transport.write(FULL)
        if transport.can_write_eof():
            transport.write_eof()
        self._close_in(self._all.limits.refused)

    def data_received(self, data: bytes) -> None:
        """Bytes arrived. They do not extend the time for a head."""
        if self._refused:
            return
        super().data_received(data)
        if self.cycle is not None and not self.cycle.response_complete:
            self._head_begun = False
            if not self.flow.write_paused:
                self._never_close()
        elif not self._head_begun:
            self._head_begun = True
            self._close_in(self._all.limits.head)

    def send_400_response(self, msg: str) -> None:
        """What came is not HTTP."""
        self._all.say("400 malformed no HTTP")
        super().send_400_response(msg)

    def on_response_complete(self) -> None:
        """An answer was given; the next request may follow."""
        self._all.answered(self)
        self._head_begun = False
        self._close_in(self._all.limits.idle)
        super().on_response_complete()
        if self.cycle is not None and not self.cycle.response_complete:  # the next one was there already
            self._never_close()

    def pause_writing(self) -> None:
        """What is written is not read at the other end."""
        super().pause_writing()
        self._close_in(self._all.limits.idle)

    def resume_writing(self) -> None:
        """It is read again."""
        super().resume_writing()
        if self.cycle is not None and not self.cycle.response_complete:
            self._never_close()

    def connection_lost(self, exc: Exception | None) -> None:
        """It is closed."""
        self._never_close()
        self._all.remove(self)
        super().connection_lost(exc)

    def _close_in(self, seconds: float) -> None:
        self._never_close()
        self._deadline = self.loop.call_later(seconds, self.transport.abort)

    def _never_close(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None
