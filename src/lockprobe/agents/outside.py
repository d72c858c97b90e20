"""Names of agents outside of the loop: people at a page (``participant``, ``participant:ID``) and clients with tools.

A client connects to ``lockprobe mcp``, and whoever starts that server chooses its name: ``mcp:NAME``.
"""

from __future__ import annotations

import re

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.spec import MCP, PEOPLE, spec_kind

SAME_IN_ALL_TRIALS = ("client", "wording")
"""Facts of a client that may not change under its name: records that differ in them are different conditions."""

_FORMS = {
    PEOPLE: (r"(:[a-z0-9]{4,32})?", "participant, or participant:ID with 4 to 32 lower-case letters and digits"),
    MCP: (
        r":[A-Za-z0-9][A-Za-z0-9._-]{0,63}",
        "mcp:NAME with at most 64 letters, digits, dots, hyphens and underscores",
    ),
}
"""How the specs of people and of clients go on after their kind, and the same in words."""


def participant_spec(identity: str) -> str:
    """The agent spec of one person."""
    return f"{PEOPLE}:{identity}"


def check_outside(spec: str, kind: str = "") -> str:
    """A spec that names a person or a client; ``kind`` is that of its own unless it is given.

    Raises:
        BadValue: If it names none.
    """
    kind = kind or spec_kind(spec)
    form, expected = _FORMS[kind]
    if not re.fullmatch(f"{kind}{form}", spec):
        raise BadValue("agent", spec, expected)
    return spec
