"""Starting and stopping a server. When it stops, it finishes the requests that are under way."""

from __future__ import annotations

import asyncio
import contextlib
import signal
import socket
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager
from math import ceil

import uvicorn

from lockprobe.foundation.http_server.connections import Connections
from lockprobe.foundation.http_server.listening import QUEUE

_ACCEPTED_AT_ONCE = 64
"""Connections that are accepted before one of them is looked at: each is an open file."""


@asynccontextmanager
async def running(
    app: object,
    listening: socket.socket,
    connections: Connections,
    *,
    seconds_to_finish: int,
) -> AsyncIterator[None]:
    """An ASGI application that answers requests on a socket.

    Args:
        app: The application.
        listening: The socket.
        connections: The connections and their limits.
        seconds_to_finish: Time for requests that are under way when the server stops.
    """
    server = _Server(_config(app, connections, seconds_to_finish), connections)
    task = asyncio.create_task(server.serve(sockets=[listening]))
    await server.ready.wait()
    listening.listen(QUEUE)  # uvicorn made the queue as short as what is accepted at once
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

    def __init__(self, config: uvicorn.Config, connections: Connections) -> None:
        super().__init__(config)
        self.ready = asyncio.Event()
        self._connections = connections

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start to answer requests."""
        await super().startup(sockets)
        self.ready.set()

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Finish the requests under way; refuse new connections."""
        self._connections.end()
        await super().shutdown(sockets)

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Capture no signals."""
        yield


def _config(app: object, connections: Connections, seconds_to_finish: int) -> uvicorn.Config:
    return uvicorn.Config(
        app,  # type: ignore[arg-type] # an ASGI application
        http=connections.protocol,  # type: ignore[arg-type] # makes protocols, as the class does
        ws="none",
        lifespan="off",
        log_config=None,
        access_log=False,
        proxy_headers=False,
        server_header=False,
        date_header=False,
        timeout_keep_alive=ceil(connections.limits.idle),
        backlog=_ACCEPTED_AT_ONCE,
        timeout_graceful_shutdown=seconds_to_finish,
    )
