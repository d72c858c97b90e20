"""The modalities that an agent reads, and the error if it gets pictures that it cannot read."""

from __future__ import annotations

from typing import Literal

from lockprobe.foundation.errors import BadValue
from lockprobe.trial.record import Percept

Senses = Literal["reports", "pictures"]
"""What an agent can read: only reports in words, or pictures too."""


def refuse_pictures(percept: Percept, reader: str) -> None:
    """Raise an error if an agent that reads only reports gets pictures.

    Raises:
        BadValue: If there are pictures and neither an outcome nor positions.
    """
    if percept.pictures and percept.positions is None and percept.outcome is None:
        raise BadValue("modality", "pictures", f"reports: {reader} cannot read pictures; viewer:STRATEGY can")
