"""The specs of people: ``participant`` for all of them, ``participant:ID`` for one."""

from __future__ import annotations

import re

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.spec import PEOPLE

_ID = re.compile(r"[a-z0-9]{4,32}")


def participant_spec(identity: str) -> str:
    """The agent spec of one person.

    >>> participant_spec("3f9a01bc")
    'participant:3f9a01bc'
    """
    return f"{PEOPLE}:{identity}"


def check_participant(spec: str) -> None:
    """Refuse a spec that is no participant.

    Raises:
        BadValue: If it is neither ``participant`` nor ``participant:ID``.
    """
    if spec != PEOPLE and not _ID.fullmatch(spec.removeprefix(f"{PEOPLE}:")):
        raise BadValue("agent", spec, "participant, or participant:ID with 4 to 32 lower-case letters and digits")
