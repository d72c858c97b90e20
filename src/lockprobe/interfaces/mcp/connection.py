"""The connection of a client, and its facts for the record."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from lockprobe.foundation.redaction import without_secrets
from lockprobe.foundation.terminal_text import printable
from lockprobe.trial.record import Fact

_LONGEST = 100


@dataclass(frozen=True, slots=True, kw_only=True)
class Connection:
    """A client's description of itself.

    Attributes:
        client: The name that the program gives; empty if it gives none.
        version: Its version.
        protocol: The version of the Model Context Protocol.
    """

    client: str = ""
    version: str = ""
    protocol: str = ""


def facts_of(connection: Connection, wording: str, *, position: int, resumed: int) -> Mapping[str, Fact]:
    """The facts of a record.

    Args:
        connection: The client.
        wording: Fingerprint of instruction and tools.
        position: The number of trials that the connection has begun, including this one.
        resumed: How often the trial was resumed after a client or the server had stopped.
    """
    facts: dict[str, Fact] = {
        "protocol": f"MCP tools {connection.protocol}".rstrip(),
        "client": _plain(connection.client),
        "client_version": _plain(connection.version),
        "wording": wording,
        "position": position,
    }
    return facts | ({"resumed": resumed} if resumed else {})


def _plain(text: str) -> str:
    return printable(without_secrets(text))[:_LONGEST]
