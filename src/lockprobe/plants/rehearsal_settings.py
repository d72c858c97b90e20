"""The options of the plant ``rig``: how real a rehearsal is, and where the truth comes from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from lockprobe.errors import BadValue

__all__ = ["RehearsalRung", "RehearsalSettings", "RehearsalTruth"]

RehearsalRung = Literal["scripted", "twin", "wire"]
"""The rungs below a robot; :mod:`lockprobe.plants.hardware.rehearsal` says what they are."""

RehearsalTruth = Literal["simulation", "camera"]
"""Where the truth of a rehearsal comes from: the simulated joints, or pictures of them through a camera's library."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RehearsalSettings:
    """A rehearsal.

    Attributes:
        rung: How real it is.
        truth: Where the truth comes from.

    Raises:
        BadValue: If a camera is to look where nothing can be seen.
    """

    rung: RehearsalRung = "scripted"
    truth: RehearsalTruth = "simulation"

    def __post_init__(self) -> None:
        if (self.rung, self.truth) == ("scripted", "camera"):
            raise BadValue("truth", self.truth, "simulation with rung=scripted: it has nothing that a camera could see")
