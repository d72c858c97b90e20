"""The tools ``observe`` and ``attempt`` of the Model Context Protocol.

A refused call is a result that the model reads, marked as an error. Results hold text and pictures and no structured
content: some clients show a model that in place of the text.
"""

from __future__ import annotations

import base64
import logging
from collections.abc import Mapping
from importlib.metadata import version
from typing import Any

from lockprobe.foundation.errors import needing
from lockprobe.interfaces.mcp.session import CallRefused, Connection, Reply, ToolSession
from lockprobe.interfaces.mcp.wording import tool_schema

with needing("agents with tools", "mcp"):
    import mcp_types as types
    from mcp.server.context import ServerRequestContext
    from mcp.server.lowlevel import Server

_INSTRUCTIONS = (
    "A lockbox to open, one trial after another. Call observe for a trial and its instruction, then attempt, one "
    "call at a time, until the trial is over."
)

_log = logging.getLogger(__name__)

Context = ServerRequestContext[Any, Any]


def make_server(session: ToolSession) -> Server[Any]:
    """The server of a session."""
    tools = _tools(session)

    async def list_tools(context: Context, params: types.PaginatedRequestParams | None) -> types.ListToolsResult:
        return types.ListToolsResult(tools=tools)

    async def call_tool(context: Context, params: types.CallToolRequestParams) -> types.CallToolResult:
        try:
            return _result(await _called(session, _connection(context), params.name, params.arguments or {}))
        except CallRefused as refused:
            if refused.__cause__ is not None:  # for whoever started the server
                _log.error("%s", refused.__cause__)
            return types.CallToolResult(content=[types.TextContent(text=str(refused))], is_error=True)

    return Server(
        "lockprobe",
        version=version("lockprobe"),
        instructions=_INSTRUCTIONS,
        on_list_tools=list_tools,
        on_call_tool=call_tool,
    )


def _tools(session: ToolSession) -> list[types.Tool]:
    study = session.study
    schema = tool_schema(len(study.box.joints), assessment=study.assessment, hypothesis=study.hypothesis != "off")
    return [
        types.Tool(
            name="observe",
            description="Begin the next trial, or read the one under way: its instruction, its steps and what is seen.",
            input_schema={"type": "object", "properties": {}, "additionalProperties": False},
        ),
        types.Tool(
            name="attempt",
            description="Attempt one joint, and read what follows. Every call is one step of the trial.",
            input_schema=schema,
            annotations=types.ToolAnnotations(destructive_hint=False, idempotent_hint=False, open_world_hint=False),
        ),
    ]


async def _called(session: ToolSession, connection: Connection, name: str, given: Mapping[str, object]) -> Reply:
    if name == "observe":
        _check_arguments(name, given, ())
        return await session.observe(connection)
    if name != "attempt":
        raise CallRefused(f"no tool is called {name[:40]!r}; there are observe and attempt.")
    known = tuple(_tools(session)[1].input_schema["properties"])
    _check_arguments(name, given, known)
    texts = {key: _text(key, value) for key, value in given.items() if value is not None}
    if "joint" not in texts:
        raise CallRefused("joint is missing. This call did nothing.")
    return await session.attempt(texts["joint"], texts.get("last_action"), hypothesis=texts.get("hypothesis", ""))


def _check_arguments(tool: str, given: Mapping[str, object], known: tuple[str, ...]) -> None:
    for name in given:
        if name not in known:
            takes = ", ".join(known) or "no argument"
            raise CallRefused(f"{tool} has no argument {name[:40]!r}; it takes {takes}. This call did nothing.")


def _text(name: str, value: object) -> str:
    if not isinstance(value, str):
        raise CallRefused(f"{name}: expected text, got {type(value).__name__}. This call did nothing.")
    return value


def _result(reply: Reply) -> types.CallToolResult:
    pictures = [
        types.ImageContent(data=base64.b64encode(picture.png).decode(), mime_type="image/png")
        for picture in reply.pictures
    ]
    return types.CallToolResult(content=[types.TextContent(text=reply.text), *pictures])


def _connection(context: Context) -> Connection:
    """The client's description of itself."""
    params = context.session.client_params
    return Connection(
        client="" if params is None else params.client_info.name,
        version="" if params is None else params.client_info.version,
        protocol=context.protocol_version,
    )
