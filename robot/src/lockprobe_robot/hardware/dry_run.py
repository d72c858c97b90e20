"""The dry run: an arm makes every joint's motion above the board, and touches nothing. The last rung before the robot.

The motion is the guarded move along a handle's path, raised along the board's normal. In free air its verdict has to be
``moved``. A force that would count as a locked handle, or a hand that sinks, stops the arm.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from lockprobe.foundation.errors import BadValue, PlantFault
from lockprobe.trial.record import Fact
from lockprobe_robot.arm.guarded_move import GuardedMove, HandlePath, TouchVerdict
from lockprobe_robot.arm.protocol import Vector
from lockprobe_robot.hardware.bounds import Bounded

HEIGHT, LOWEST, HIGHEST = 0.10, 0.05, 0.30
"""Height of the motions above the handles, metres: the default, the least and the greatest."""

MOST_ASTRAY = 0.007
"""Distance from the commanded position, metres, above which no handle should be touched: with handles that far from
where the robot believes them, one of 200 simulated verdicts was wrong (robot/docs/twin.md)."""

_SUNK = 0.5
"""Share of the height below which the hand must not come."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DryMotion:
    """One motion of a dry run, with its measurements.

    Attributes:
        joint: Name of the joint.
        start: The handle's start position, 0 or 1.
        verdict: The verdict of the guarded move; ``moved`` in free air.
        force: Largest change of the force on the hand, newtons.
        astray: Largest tracking error along the handle's path: distance of the tool from its commanded position,
            metres. Descent and rise, which are faster, do not count.
        lowest: Lowest height of the tool above the tops of the handles, metres.
        seconds: Duration by the arm's clock.
    """

    joint: str
    start: int
    verdict: TouchVerdict
    force: float
    astray: float
    lowest: float
    seconds: float


@dataclass(frozen=True, slots=True, kw_only=True)
class DryRun:
    """The result of a dry run.

    Attributes:
        rung: Always ``dry-run``; ``facts["rung"]`` says how real the arm was.
        box: Name of the box.
        height: Height of the motions above the handles, metres.
        motions: All motions, in order.
        facts: The facts of the rig.
    """

    rung: str = "dry-run"
    box: str
    height: float
    motions: tuple[DryMotion, ...]
    facts: Mapping[str, Fact]

    @property
    def complaints(self) -> tuple[str, ...]:
        """The motions that differed from free air, one sentence each; empty if the arm may touch the board."""
        return tuple(
            f"{one.joint} from {one.start}: the verdict is {one.verdict}, in free air it is moved"
            for one in self.motions
            if one.verdict != "moved"
        )


def check_height(height: float) -> None:
    """Check the height of a dry run, metres.

    Raises:
        BadValue: If it is not in [0.05, 0.3].
    """
    if not LOWEST <= height <= HIGHEST:
        raise BadValue("height", height, f"metres from {LOWEST} to {HIGHEST}")


def run_dry(
    arm: Bounded,
    ways: Mapping[str, tuple[HandlePath, HandlePath]],
    *,
    height: float,
    move: GuardedMove,
    tell: Callable[[DryMotion], None],
) -> tuple[DryMotion, ...]:
    """Make every joint's motion in both directions above the board.

    Args:
        arm: The arm within its bounds, which ask the operator before the first motion.
        ways: Joint name -> paths of its handle from position 0 and from position 1.
        height: Height above the handles, metres.
        move: The guarded move.
        tell: Called after every motion.

    Raises:
        PlantFault: If the arm fails, leaves its bounds, sinks, or feels a force that would count as a locked handle.
            The arm is stopped first.
    """
    made: list[DryMotion] = []
    arm.home()
    for joint, way in ways.items():
        for start, path in enumerate(way):
            watched = _MonitoredArm(arm, path, height, move)
            touch = move.attempt(watched, replace(path, points=path.points - height * path.axis))
            made.append(
                DryMotion(
                    joint=joint,
                    start=start,
                    verdict=touch.verdict,
                    force=watched.felt,
                    astray=watched.astray,
                    lowest=watched.lowest,
                    seconds=touch.seconds,
                )
            )
            tell(made[-1])
    return tuple(made)


class _MonitoredArm:
    """An arm that is measured after every command, and stopped if it touches something or sinks."""

    def __init__(self, arm: Bounded, path: HandlePath, height: float, move: GuardedMove) -> None:
        self._arm, self._path, self._height, self._move = arm, path, height, move
        self._zero: Vector | None = None
        self.felt, self.astray, self.lowest = 0.0, 0.0, float("inf")
        self.home, self.reach, self.position, self.force = arm.home, arm.reach, arm.position, arm.force

    @property
    def period(self) -> float:
        return self._arm.period

    @property
    def time(self) -> float:
        return self._arm.time

    def follow(self, position: Vector, velocity: Vector, *, stiffness: float) -> None:
        self._arm.follow(position, velocity, stiffness=stiffness)
        tool, force = self._arm.position(), self._arm.force()
        self._zero = force if self._zero is None else self._zero
        self.felt = max(self.felt, float(np.linalg.norm(force - self._zero)))
        if stiffness == self._move.held_stiffness:  # along the path
            self.astray = max(self.astray, float(np.linalg.norm(position + self.period * velocity - tool)))
        self.lowest = min(self.lowest, float((self._path.points[0] - tool) @ self._path.axis))
        if self.felt > (most := self._move.held_force):
            self._fault(f"the hand feels {self.felt:.1f} N where nothing should be, at most {most:g} N")
        if self.lowest < _SUNK * self._height:
            self._fault(
                f"the hand is {1000 * self.lowest:.0f} mm above the handles, expected {1000 * self._height:.0f} mm"
            )

    def _fault(self, why: str) -> None:
        self._arm.stop()
        raise PlantFault(why)
