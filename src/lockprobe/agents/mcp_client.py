"""The spec of an agent that connects to ``lockprobe mcp``: ``mcp:NAME``. Whoever starts the server chooses the name."""

from __future__ import annotations

import re

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.spec import MCP

SAME_IN_ALL_TRIALS = ("client", "wording")
"""Facts that may not change under one agent's name, because records that differ in them are different conditions."""

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}")


def client_spec(name: str) -> str:
    """The agent spec of a name.

    >>> client_spec("claude-code")
    'mcp:claude-code'

    Raises:
        BadValue: As :func:`check_client`.
    """
    check_client(spec := f"{MCP}:{name}")
    return spec


def check_client(spec: str) -> None:
    """Refuse a spec that names no client.

    Raises:
        BadValue: If it is not ``mcp:NAME``.
    """
    if not _NAME.fullmatch(spec.removeprefix(f"{MCP}:")) or ":" not in spec:
        raise BadValue("agent", spec, f"{MCP}:NAME with at most 64 letters, digits, dots, hyphens and underscores")
