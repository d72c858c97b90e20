"""Hashes of the settings of a study: equal settings have equal hashes, in whatever order agents and conditions stand.

Their order changes no trial.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping

_SETS = ("agents", "conditions")
"""Lists among the settings whose order is no setting."""


def in_no_order(settings: Mapping[str, object]) -> dict[str, object]:
    """Settings with agents and conditions sorted.

    >>> in_no_order({"agents": ["round-robin", "random"]})
    {'agents': ['random', 'round-robin']}
    """
    found = dict(settings)
    for name in _SETS:
        if isinstance(there := found.get(name), list):
            found[name] = sorted(there, key=sorted_text)
    return found


def sorted_text(value: object) -> str:
    """A value as JSON with sorted names, the same for equal values."""
    return json.dumps(value, sort_keys=True)


def hash_of(settings: Mapping[str, object]) -> str:
    """The SHA-256 of settings as JSON has them, in hexadecimal digits."""
    plain = json.loads(json.dumps(settings), parse_float=_number)
    return hashlib.sha256(sorted_text(plain).encode()).hexdigest()


def _number(text: str) -> float:
    """A number as JSON has it; 1.0 and 1 are the same."""
    return int(number) if (number := float(text)).is_integer() else number
