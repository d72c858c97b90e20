"""The options of the plant ``rig``: the rung of the rehearsal, and the source of the truth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from lockprobe.foundation.errors import BadValue

RehearsalRung = Literal["scripted", "twin"]
"""The rungs below a robot; :mod:`lockprobe_robot.hardware.rehearsal` says what they are."""

RehearsalTruth = Literal["simulation", "camera"]
"""Where the truth of a rehearsal comes from: the simulated joints, or pictures of them through a camera's library."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RehearsalSettings:
    """The settings of a rehearsal.

    Attributes:
        rung: The rung, ``scripted`` or ``twin``.
        truth: Source of the truth.

    Raises:
        BadValue: If the truth is to come from a camera on a rung without pictures.
    """

    rung: RehearsalRung = "scripted"
    truth: RehearsalTruth = "simulation"

    def __post_init__(self) -> None:
        if (self.rung, self.truth) == ("scripted", "camera"):
            raise BadValue("truth", self.truth, "simulation with rung=scripted: it has nothing that a camera could see")
