"""The server over standard input and output: the client starts it, and it ends when the client goes."""

from __future__ import annotations

from lockprobe.errors import needing
from lockprobe.mcp_server.session import ToolSession
from lockprobe.mcp_server.tools import make_server

with needing("agents with tools", "mcp"):
    from mcp.server.stdio import stdio_server

__all__ = ["serve_stdio"]


async def serve_stdio(session: ToolSession) -> None:
    """Serve one client until it closes standard input. Nothing else may be printed to standard output."""
    server = make_server(session)
    async with stdio_server() as (reading, writing):
        await server.run(reading, writing, server.create_initialization_options())
