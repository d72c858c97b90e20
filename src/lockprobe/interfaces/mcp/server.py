"""The tools ``observe`` and ``attempt`` of the Model Context Protocol, over standard input and output.

The client starts the server, which ends with it. A refused call is a result that the model reads, marked as an error.
Results hold text and pictures and no structured content: some clients show a model that in place of the text.
"""

from __future__ import annotations

import asyncio
import base64
import json
import logging
import sys
from collections.abc import AsyncIterator
from importlib.metadata import version
from typing import Any

from lockprobe.foundation.errors import BadValue, needing
from lockprobe.interfaces.mcp.session import CallRefused, ToolSession

with needing("agents with tools", "mcp"):
    import mcp_types as types
    from mcp.server.context import ServerRequestContext
    from mcp.server.lowlevel import Server
    from mcp.server.stdio import stdio_server

LONGEST_LINE = 64 * 1024
"""Bytes of the longest message. A longer one is answered as malformed, and never kept as a whole."""

_INSTRUCTIONS = (
    "A lockbox to open, one trial after another. Call observe for a trial and its instruction, then attempt, one "
    "call at a time, until the trial is over."
)

_DESCRIPTIONS = {
    "observe": "Begin the next trial, or read the one under way: its instruction, its steps and what is seen.",
    "attempt": "Attempt one joint, and read what follows. Every call is one step of the trial.",
}

_log = logging.getLogger(__name__)

Context = ServerRequestContext[Any, Any]


def make_server(session: ToolSession) -> Server[Any]:
    """The server of a session."""
    tools = [
        types.Tool(name=name, description=_DESCRIPTIONS[name], input_schema=schema)
        for name, schema in session.schemas.items()
    ]

    async def list_tools(context: Context, params: types.PaginatedRequestParams | None) -> types.ListToolsResult:
        return types.ListToolsResult(tools=tools)

    async def call_tool(context: Context, params: types.CallToolRequestParams) -> types.CallToolResult:
        client = context.session.client_params
        facts = {
            "protocol": f"MCP tools {context.protocol_version}",
            "client": "" if client is None else client.client_info.name,
            "client_version": "" if client is None else client.client_info.version,
        }
        try:
            reply = await session.call(params.name, params.arguments or {}, facts)
        except CallRefused as refused:
            if refused.__cause__ is not None:  # for whoever started the server
                _log.error("%s", refused.__cause__)
            return types.CallToolResult(content=[types.TextContent(text=str(refused))], is_error=True)
        pictures = [
            types.ImageContent(data=base64.b64encode(picture.png).decode(), mime_type="image/png")
            for picture in reply.pictures
        ]
        return types.CallToolResult(content=[types.TextContent(text=reply.text), *pictures])

    return Server(
        "lockprobe",
        version=version("lockprobe"),
        instructions=_INSTRUCTIONS,
        on_list_tools=list_tools,
        on_call_tool=call_tool,
    )


async def serve_stdio(session: ToolSession) -> None:
    """Serve one client until it closes standard input. Nothing else may be printed to standard output.

    Raises:
        BadValue: If standard input is a file.
    """
    reader = asyncio.StreamReader(limit=LONGEST_LINE)  # its reading can be cancelled, unlike that of a thread
    try:
        await asyncio.get_running_loop().connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), sys.stdin)
    except ValueError:
        raise BadValue("standard input", "a file", "a pipe from the client that starts this command") from None
    server, lines = make_server(session), _lines(reader)
    async with stdio_server(stdin=lines) as (reading, writing):  # type: ignore[arg-type] # it is only iterated over
        await server.run(reading, writing, server.create_initialization_options())


async def _lines(reader: asyncio.StreamReader) -> AsyncIterator[str]:
    """The messages, one per line."""
    while True:
        try:
            line = await reader.readline()
        except ValueError:  # longer than the limit
            line = b"too long\n"
        if not line:
            return
        text = line.decode("utf-8", "replace")
        try:  # a client may send the arguments of a call as the text of an object
            message = json.loads(text)
            message["params"]["arguments"] = json.loads(message["params"]["arguments"])
            yield json.dumps(message)
        except (ValueError, LookupError, TypeError, RecursionError):
            yield text
