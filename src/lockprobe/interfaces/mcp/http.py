"""The MCP server over streamable HTTP, on loopback and behind a token."""

from __future__ import annotations

import hmac
import logging
import socket
from collections.abc import Callable

from lockprobe.foundation.errors import needing
from lockprobe.interfaces.mcp.client_sessions import App, ClientSessions, Receive, Scope, Send
from lockprobe.interfaces.mcp.session import ToolSession
from lockprobe.interfaces.mcp.tools import make_server

with needing("agents with tools", "mcp"):
    from lockprobe.foundation.http_server.connections import ConnectionLimits, Connections, raise_file_limit
    from lockprobe.foundation.http_server.running import running, stop_signals

__all__ = ["HOST", "LARGEST_BODY", "PATH", "TOKEN", "serve_http"]

HOST = "127.0.0.1"
PATH = "/mcp"

TOKEN = "LOCKPROBE_MCP_TOKEN"  # noqa: S105 - its name
"""The variable of the environment that holds the token; without it a token is drawn at every start."""

LARGEST_BODY = 64 * 1024
"""Bytes of the largest request."""

_SECONDS_UNUSED = 30 * 60
"""The time after which a session that nobody uses ends; its client connects anew."""

_SECONDS_TO_FINISH = 2

_log = logging.getLogger(__name__)


async def serve_http(
    session: ToolSession, listening: socket.socket, token: str, announce: Callable[[str], None]
) -> None:
    """Serve until Ctrl-C or SIGTERM. ``announce`` gets the address as soon as clients can come."""
    app = make_server(session).streamable_http_app(
        host=HOST,
        streamable_http_path=PATH,
        json_response=True,
        max_request_body_size=LARGEST_BODY,
        session_idle_timeout=_SECONDS_UNUSED,
        max_sessions=None,  # at its own limit it locks everybody out
    )
    sessions = ClientSessions(app, lambda: session.player)
    door = _guarded(sessions, token)
    connections = Connections(ConnectionLimits().within(raise_file_limit()), _log.warning)
    with stop_signals() as stopped:
        async with running(door, listening, connections, lifespan="on", seconds_to_finish=_SECONDS_TO_FINISH):
            announce(f"http://{HOST}:{listening.getsockname()[1]}{PATH}")
            await stopped.wait()
            await sessions.close()


def _guarded(app: App, token: str) -> App:
    """The application behind the token: a request without the token is refused before its body is read."""
    right = f"Bearer {token}".encode()

    async def guard(scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "http":
            given = [value for name, value in scope["headers"] if name == b"authorization"]
            if len(given) != 1 or not hmac.compare_digest(given[0], right):
                headers = [
                    (b"www-authenticate", b"Bearer"),
                    (b"content-type", b"text/plain"),
                    (b"connection", b"close"),
                ]
                await send({"type": "http.response.start", "status": 401, "headers": headers})
                await send({"type": "http.response.body", "body": b"the token is missing or wrong\n"})
                return
            if scope["path"] == f"{PATH}/":  # as many people write it; a redirect would lose the token
                scope = {**scope, "path": PATH, "raw_path": PATH.encode()}
        await app(scope, receive, send)

    return guard
