"""The MCP server over streamable HTTP, on loopback and behind a token."""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import signal
import socket
from collections.abc import Awaitable, Callable, Iterator, MutableMapping
from typing import Any

from lockprobe.errors import BadValue, needing
from lockprobe.mcp_server.session import ToolSession
from lockprobe.mcp_server.tools import make_server

with needing("agents with tools", "mcp"):
    import uvicorn

__all__ = ["HOST", "LARGEST_BODY", "PATH", "TOKEN", "check_token", "listen", "serve_http"]

HOST = "127.0.0.1"
PATH = "/mcp"

TOKEN = "LOCKPROBE_MCP_TOKEN"  # noqa: S105 - its name
"""The variable of the environment that holds the token; without it a token is drawn at every start."""

LARGEST_BODY = 64 * 1024
"""Bytes of the largest request."""

_SHORTEST_TOKEN = 16
_MOST_CONNECTIONS = 64
_SECONDS_TO_FINISH = 2

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]


def check_token(token: str) -> None:
    """Refuse a token that is short or does not fit in a header. The message does not repeat it.

    Raises:
        BadValue: If it is one.
    """
    if len(token) < _SHORTEST_TOKEN or not all("!" <= sign <= "~" for sign in token):
        expected = f"{_SHORTEST_TOKEN} or more of letters, digits and signs, without spaces"
        raise BadValue(TOKEN, f"{len(token)} characters", expected)


def listen(port: int) -> socket.socket:
    """A listening socket on loopback; port 0 takes any free port.

    Raises:
        BadValue: If the port is not free.
    """
    found = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        found.bind((HOST, port))
        found.listen()
    except OSError as error:
        found.close()
        raise BadValue("port", port, f"a free port of {HOST} ({error.strerror})") from None
    return found


async def serve_http(
    session: ToolSession, listening: socket.socket, token: str, announce: Callable[[str], None]
) -> None:
    """Serve until Ctrl-C or SIGTERM. ``announce`` gets the address as soon as clients can come."""
    server = make_server(session)
    app = server.streamable_http_app(
        host=HOST, streamable_http_path=PATH, json_response=True, max_request_body_size=LARGEST_BODY, max_sessions=64
    )
    running = _Uvicorn(_config(_guarded(app, token)))
    loop = asyncio.get_running_loop()
    for name in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(name, running.stop)
    try:
        announce(f"http://{HOST}:{listening.getsockname()[1]}{PATH}")
        await running.serve(sockets=[listening])
    finally:
        for name in (signal.SIGINT, signal.SIGTERM):
            loop.remove_signal_handler(name)


class _Uvicorn(uvicorn.Server):
    """A server whose caller handles signals."""

    def stop(self) -> None:
        self.should_exit = True

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Capture no signals."""
        yield


def _guarded(app: App, token: str) -> App:
    """The application behind the token: a request without the token is refused before its body is read."""
    right = f"Bearer {token}".encode()

    async def guard(scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "http":
            given = [value for name, value in scope["headers"] if name == b"authorization"]
            if len(given) != 1 or not hmac.compare_digest(given[0], right):
                headers = [(b"www-authenticate", b"Bearer"), (b"content-type", b"text/plain")]
                await send({"type": "http.response.start", "status": 401, "headers": headers})
                await send({"type": "http.response.body", "body": b"the token is missing or wrong\n"})
                return
        await app(scope, receive, send)

    return guard


def _config(app: App) -> uvicorn.Config:
    return uvicorn.Config(
        app,
        lifespan="on",
        ws="none",
        log_config=None,
        access_log=False,
        proxy_headers=False,
        server_header=False,
        limit_concurrency=_MOST_CONNECTIONS,
        timeout_graceful_shutdown=_SECONDS_TO_FINISH,
    )
