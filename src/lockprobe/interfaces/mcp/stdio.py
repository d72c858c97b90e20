"""The MCP server over standard input and output: the client starts it, and it ends with the client."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import AsyncIterator
from typing import Any

from lockprobe.foundation.errors import BadValue, needing
from lockprobe.interfaces.mcp.session import ToolSession
from lockprobe.interfaces.mcp.tools import make_server

with needing("agents with tools", "mcp"):
    from mcp.server.stdio import stdio_server

LONGEST_LINE = 64 * 1024
"""Bytes of the longest message. A longer one is read, is answered as malformed, and never kept as a whole."""

_PART = 16 * 1024


async def serve_stdio(session: ToolSession) -> None:
    """Serve one client until it closes standard input. Nothing else may be printed to standard output.

    Raises:
        BadValue: If standard input is a file.
    """
    server = make_server(session)
    lines: Any = _lines(await _input())  # the SDK iterates over it, and asks for nothing else
    async with stdio_server(stdin=lines) as (reading, writing):
        await server.run(reading, writing, server.create_initialization_options())


async def _input() -> asyncio.StreamReader:
    """Standard input as a stream whose reading can be cancelled, unlike a reading thread."""
    reader = asyncio.StreamReader()
    try:
        await asyncio.get_running_loop().connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), sys.stdin)
    except ValueError:
        raise BadValue("standard input", "a file", "a pipe from the client that starts this command") from None
    return reader


async def _lines(reader: asyncio.StreamReader) -> AsyncIterator[str]:
    """The messages, one per line. A message that is too long is cut, and so malformed."""
    kept, after = b"", b""
    while part := after or await reader.read(_PART):
        line, end, after = part.partition(b"\n")
        kept = (kept + line)[:LONGEST_LINE]
        if end:
            yield kept[:LONGEST_LINE].decode("utf-8", "replace")
            kept = b""
