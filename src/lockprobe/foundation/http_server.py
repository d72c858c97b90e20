"""An HTTP server that listens, runs and stops: uvicorn, with a time for the head of a request. No application.

A proxy in front may add limits; these are what a server needs without one.
"""

from __future__ import annotations

import asyncio
import resource
import signal
import socket
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager, suppress
from functools import partial
from typing import Any

import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol

from lockprobe.foundation.errors import BadValue

SECONDS_FOR_A_HEAD = 10.0
"""The time for the head of a request to arrive after its connection opened or after its first byte; uvicorn waits
forever."""

_SECONDS_IDLE = 30
"""How long a connection stays open after an answer."""

_QUEUE = 2048
"""Connections that wait to be accepted; the operating system may allow fewer."""

_ACCEPTED_AT_ONCE = 64
"""Connections that are accepted before one of them is looked at: each is an open file."""

_MOST_FILES = 65_536
"""Open files that are asked of the system: each connection is one."""

_FILES_KEPT_BACK = 64
"""Open files that no connection takes, so that what people do can be written; one more is closed at once."""


def listen(host: str, port: int) -> socket.socket:
    """A listening socket; port 0 takes any free port.

    Raises:
        BadValue: If the host or the port cannot be used.
    """
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
    except (OSError, UnicodeError):
        raise BadValue("host", host, "a name or IP address of this machine") from None
    found = socket.socket(family, kind, protocol)
    try:
        found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        found.bind(address)
        found.listen(_QUEUE)
    except OSError as error:
        found.close()
        raise BadValue("port", port, f"a free port of {host} ({error.strerror})") from None
    found.setblocking(False)
    return found


@asynccontextmanager
async def running(
    app: object, listening: socket.socket, say: Callable[[str], None], *, seconds_to_finish: int
) -> AsyncIterator[None]:
    """An ASGI application that answers requests on a socket.

    Args:
        app: The application.
        listening: The socket.
        say: Gets a line for what came and is no HTTP, which the application never sees.
        seconds_to_finish: Time for requests that are under way when the server stops.
    """
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    most = _MOST_FILES if hard == resource.RLIM_INFINITY else min(hard, _MOST_FILES)
    if soft != resource.RLIM_INFINITY and soft < most:
        with suppress(OSError, ValueError):  # a system may allow fewer than it says
            resource.setrlimit(resource.RLIMIT_NOFILE, (most, hard))
    soft, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    files = most if soft == resource.RLIM_INFINITY else soft
    server = _Server(
        uvicorn.Config(
            app,  # type: ignore[arg-type] # an ASGI application
            http=partial(_Connection, say, files - _FILES_KEPT_BACK),  # type: ignore[arg-type] # makes protocols
            ws="none",
            lifespan="off",
            log_config=None,
            access_log=False,
            proxy_headers=False,
            server_header=False,
            date_header=False,
            timeout_keep_alive=_SECONDS_IDLE,
            backlog=_ACCEPTED_AT_ONCE,
            timeout_graceful_shutdown=seconds_to_finish,
        )
    )
    task = asyncio.create_task(server.serve(sockets=[listening]))
    await server.ready.wait()
    listening.listen(_QUEUE)  # uvicorn made the queue as short as what is accepted at once
    try:
        yield
    finally:
        server.should_exit = True
        await task


@contextmanager
def stop_signals() -> Iterator[asyncio.Event]:
    """An event that Ctrl-C and SIGTERM set."""
    stopped = asyncio.Event()
    loop = asyncio.get_running_loop()
    for name in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(name, stopped.set)
    try:
        yield stopped
    finally:
        for name in (signal.SIGINT, signal.SIGTERM):
            loop.remove_signal_handler(name)


class _Server(uvicorn.Server):
    """A server that reports when it is ready. Its caller handles signals."""

    def __init__(self, config: uvicorn.Config) -> None:
        super().__init__(config)
        self.ready = asyncio.Event()

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start to answer requests."""
        await super().startup(sockets)
        self.ready.set()

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Capture no signals."""
        yield


class _Connection(H11Protocol):
    """A connection that is closed if the head of a request does not arrive in time, however it drips.

    Else one that says nothing stays open forever, as of a telephone that left its network.
    """

    def __init__(self, say: Callable[[str], None], most: int, **given: Any) -> None:
        super().__init__(**given)
        self._say, self._most = say, most
        self._deadline: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override] # as in the base
        super().connection_made(transport)
        if len(self.connections) > self._most:
            transport.abort()
            return
        self._deadline = self.loop.call_later(SECONDS_FOR_A_HEAD, transport.abort)

    def data_received(self, data: bytes) -> None:
        super().data_received(data)
        if self.cycle is not None and not self.cycle.response_complete:
            self._let_be()
        elif self._deadline is None:
            self._deadline = self.loop.call_later(SECONDS_FOR_A_HEAD, self.transport.abort)

    def send_400_response(self, msg: str) -> None:
        self._say("400 malformed no HTTP")
        super().send_400_response(msg)

    def connection_lost(self, exc: Exception | None) -> None:
        self._let_be()
        super().connection_lost(exc)

    def _let_be(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None
