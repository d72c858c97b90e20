"""The check of a rig before it touches a board: it makes every joint's motion above the board.

The motion is the guarded move along a handle's path, raised along the board's normal. In free air its verdict has to be
``moved``. A force that would count as a locked handle, or a hand that sinks, stops the arm.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from lockprobe_robot.arm.guarded_move import HELD_FORCE, HELD_STIFFNESS, HandlePath, TouchVerdict, guarded_move
from lockprobe_robot.arm.protocol import Vector
from lockprobe_robot.hardware.bounds import Bounded
from lockprobe_robot.hardware.rig import Rig

MOST_LATE = 0.01
"""Largest share of late commands of a move."""

MOST_ASTRAY = 0.007
"""Distance from the commanded position, metres, above which no handle should be touched: with handles that far from
where the robot believes them, all of 800 simulated verdicts were right (robot/docs/twin.md)."""

HEIGHT = 0.10
"""Height of the motions above the handles, metres."""

_SUNK = 0.5
"""Share of the height below which the hand must not come."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FreeMotion:
    """One motion above the board, with its measurements.

    Attributes:
        joint: Name of the joint.
        start: The handle's start position, 0 or 1.
        verdict: The verdict of the guarded move; ``moved`` in free air.
        force: Largest change of the force on the hand, newtons.
        astray: Largest distance of the tool from its commanded position along the handle's path, metres.
        lowest: Lowest height of the tool above the tops of the handles, metres.
    """

    joint: str
    start: int
    verdict: TouchVerdict
    force: float
    astray: float
    lowest: float


def check_rig(rig: Rig, *, tell: Callable[[FreeMotion], None]) -> list[str]:
    """Make every joint's motion in both directions above the board.

    The rig's operator has to agree before the first motion. ``tell`` is called after every motion. Returned is what is
    wrong, one sentence each; nothing if the arm may touch the board.

    Raises:
        PlantFault: If the arm fails, leaves its bounds, sinks, or feels a force that would count as a locked handle.
            The arm is stopped first.
    """
    complaints = list[str]()
    rig.arm.home()
    for joint, name in enumerate(rig.box.names):
        for start in (0, 1):
            path = rig.panel.handle_path(joint, bool(start))
            above = _ArmAbove(rig.arm, path)
            touch = guarded_move(above, replace(path, points=path.points - HEIGHT * path.axis))
            seen = {"force": above.felt, "astray": above.astray, "lowest": above.lowest}
            tell(FreeMotion(joint=name, start=start, verdict=touch.verdict, **seen))
            if touch.verdict != "moved":
                complaints.append(f"{name} from {start}: the verdict is {touch.verdict}, in free air it is moved")
            if above.astray > MOST_ASTRAY:
                off = f"{1000 * above.astray:.1f} mm, at most {1000 * MOST_ASTRAY:g} mm"
                complaints.append(f"{name} from {start}: the hand was off by {off}")
    late, commands = rig.arm.late, rig.arm.commands
    if rig.facts["rung"] == "robot" and late > MOST_LATE * commands:  # a simulation may be late
        complaints.append(f"{late} of {commands} commands were late, at most {MOST_LATE:.0%}")
    return complaints


class _ArmAbove:
    """An arm that is measured after every command, and stopped if it touches something or sinks."""

    def __init__(self, arm: Bounded, path: HandlePath) -> None:
        self._arm, self._path = arm, path
        self._zero: Vector | None = None
        self.felt, self.astray, self.lowest, self.period = 0.0, 0.0, float("inf"), arm.period
        self.home, self.reach, self.stop = arm.home, arm.reach, arm.stop
        self.position, self.force = arm.position, arm.force

    @property
    def time(self) -> float:
        return self._arm.time

    def follow(self, position: Vector, velocity: Vector, *, stiffness: float) -> None:
        self._arm.follow(position, velocity, stiffness=stiffness)
        tool, force = self._arm.position(), self._arm.force()
        self._zero = force if self._zero is None else self._zero
        self.felt = max(self.felt, float(np.linalg.norm(force - self._zero)))
        if stiffness == HELD_STIFFNESS:  # along the path: descent and rise are faster
            self.astray = max(self.astray, float(np.linalg.norm(position + self.period * velocity - tool)))
        self.lowest = min(self.lowest, float((self._path.points[0] - tool) @ self._path.axis))
        if self.felt > HELD_FORCE:
            self._arm.fault(f"the hand feels {self.felt:.1f} N where nothing is, at most {HELD_FORCE:g} N")
        if self.lowest < _SUNK * HEIGHT:
            self._arm.fault(
                f"the hand is {1000 * self.lowest:.0f} mm above the handles, expected {1000 * HEIGHT:.0f} mm"
            )
