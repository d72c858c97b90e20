"""The options of the plant ``rig``: how real a rehearsal is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

__all__ = ["RehearsalRung", "RehearsalSettings"]

RehearsalRung = Literal["scripted", "twin", "wire"]
"""The rungs below a robot; :mod:`lockprobe.plants.hardware.rehearsal` says what they are."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RehearsalSettings:
    """A rehearsal.

    Attributes:
        rung: How real it is.
    """

    rung: RehearsalRung = "scripted"
