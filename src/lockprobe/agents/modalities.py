"""What an agent can take in, and what becomes of one that is shown what it cannot."""

from __future__ import annotations

from typing import Literal

from lockprobe.errors import BadValue
from lockprobe.record import Percept

__all__ = ["Senses", "refuse_pictures"]

Senses = Literal["reports", "pictures"]
"""What an agent can take in: reports in words only, or pictures too."""


def refuse_pictures(percept: Percept, reader: str) -> None:
    """Let an agent that reads reports fail loudly where it is shown pictures instead, rather than play nonsense.

    Args:
        percept: What it was told.
        reader: What the agent is.

    Raises:
        BadValue: If there are pictures and neither an outcome nor positions.
    """
    if percept.pictures and percept.positions is None and percept.outcome is None:
        raise BadValue("modality", "pictures", f"reports: {reader} cannot see; viewer:STRATEGY looks for a strategy")
