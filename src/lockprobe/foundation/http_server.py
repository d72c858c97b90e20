"""An HTTP server that listens, runs and stops: uvicorn, with its own limits. No application.

A proxy in front adds what a server in the open needs: TLS, and time limits for whoever says nothing.
"""

from __future__ import annotations

import asyncio
import errno
import os
import signal
import socket
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager, nullcontext

import uvicorn

from lockprobe.foundation.errors import BadValue

_SECONDS_IDLE = 30
"""How long a connection stays open after an answer."""

_QUEUE = 2048
"""Connections that wait to be accepted; the operating system may allow fewer."""


def listen(host: str, port: int) -> socket.socket:
    """A listening socket; port 0 takes any free port."""
    try:
        family, _, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        found = socket.create_server(address, family=family, backlog=_QUEUE)
    except (OSError, UnicodeError) as error:
        if isinstance(error, socket.gaierror | UnicodeError) or error.errno == errno.EADDRNOTAVAIL:
            raise BadValue("host", host, "a name or IP address of this machine") from None
        raise BadValue("port", port, f"a free port of {host} ({os.strerror(error.errno or 0)})") from None
    found.setblocking(False)
    return found


@asynccontextmanager
async def running(app: object, listening: socket.socket, *, seconds_to_finish: int) -> AsyncIterator[None]:
    """An ASGI application that answers requests on a socket.

    Requests that are under way when the server stops have ``seconds_to_finish``.
    """
    server = uvicorn.Server(
        uvicorn.Config(
            app,  # type: ignore[arg-type] # an ASGI application
            http="h11",
            ws="none",
            lifespan="off",
            log_config=None,
            log_level="critical",  # what it says of an error could repeat what was sent
            access_log=False,
            proxy_headers=False,
            server_header=False,
            date_header=False,
            timeout_keep_alive=_SECONDS_IDLE,
            backlog=_QUEUE,
            timeout_graceful_shutdown=seconds_to_finish,
        )
    )
    server.capture_signals = nullcontext  # type: ignore[method-assign,assignment] # its caller handles them
    task = asyncio.create_task(server.serve(sockets=[listening]))
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
