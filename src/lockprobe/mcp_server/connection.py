"""How a client is connected, as its records say it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from lockprobe.mcp_server.isolation import Isolation
from lockprobe.record import Fact
from lockprobe.redaction import without_secrets
from lockprobe.terminal_text import printable

__all__ = ["SAME_IN_ALL_TRIALS", "Connection", "Transport", "facts_of"]

Transport = Literal["stdio", "http"]

SAME_IN_ALL_TRIALS = ("transport", "client", "isolation", "wording")
"""Facts that may not change under one agent's name, because records that differ in them are other conditions."""

_LONGEST = 100


@dataclass(frozen=True, slots=True, kw_only=True)
class Connection:
    """What a client says of itself.

    Attributes:
        identity: Tells connections apart; empty where there is only one.
        client: The name of the program, as it gives it; empty if it gives none.
        version: Its version.
        protocol: The version of the Model Context Protocol.
    """

    identity: str = ""
    client: str = ""
    version: str = ""
    protocol: str = ""


def facts_of(
    connection: Connection, transport: Transport, isolation: Isolation, wording: str, *, position: int, resumed: int
) -> Mapping[str, Fact]:
    """The facts of a record.

    Args:
        connection: The client.
        transport: How it is connected.
        isolation: Whether it could read the records.
        wording: Fingerprint of instruction and tools.
        position: How many trials the connection has begun, this one included.
        resumed: How often the trial was taken up again after a client or the server had gone.
    """
    facts: dict[str, Fact] = {
        "protocol": f"MCP tools {connection.protocol}".rstrip(),
        "transport": transport,
        "client": _plain(connection.client),
        "client_version": _plain(connection.version),
        "isolation": isolation,
        "wording": wording,
        "position": position,
    }
    return facts | ({"resumed": resumed} if resumed else {})


def _plain(text: str) -> str:
    return printable(without_secrets(text))[:_LONGEST]
