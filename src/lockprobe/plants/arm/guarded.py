"""The guarded move: one attempt of a joint by an arm that feels forces, and what it makes of them (paper, Sec. 2.1).

Above the handle, still for a moment to take the sensor's zero, down over it until the hand cages it, along the
handle's path while force and progress are watched, up again, home. The same code moves a simulated arm, a real one,
and a scripted one in tests. The zero is taken before anything is touched: a handle that presses against a finger of a
hand that is not quite over it would else count as no force, and what follows as too much.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from lockprobe.plants.arm.path import Path
from lockprobe.plants.arm.protocol import Arm, Vector

__all__ = ["GuardedMove", "Touch", "Verdict"]

Verdict = Literal["moved", "blocked", "failed"]
"""What the robot believes: the handle came along, it was held, or the hand never got over it."""

_CREEP = 0.01
"""Least speed that a descent is counted with, metres per second, so that it ends."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Touch:
    """What one attempt felt like.

    Attributes:
        verdict: What the robot believes.
        peak_force: Greatest filtered force against the drag, newtons.
        progress: How far the hand came along the path, 1 is all of it.
        seconds: By the arm's own clock, from home to home.
    """

    verdict: Verdict
    peak_force: float
    progress: float
    seconds: float

    def as_facts(self) -> Mapping[str, str | float]:
        """The same for a record, numbers rounded to six digits."""
        return {
            "verdict": self.verdict,
            "peak_force": round(self.peak_force, 6),
            "progress": round(self.progress, 6),
            "seconds": round(self.seconds, 6),
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class GuardedMove:
    """How an attempt is made, and when it is called what.

    Attributes:
        clearance: Height above the handle at which the hand comes and goes, metres.
        descent: Speed down and up, metres per second.
        lift_ramp: Acceleration down and up, metres per second squared.
        settling: Time to come to rest above the handle, over it, and when it is let go, seconds.
        taring: Time over which the sensor's zero is averaged, seconds.
        drag: Speed along the path, metres per second.
        ramp: Acceleration at the start of the drag, metres per second squared.
        overdrive: How far beyond its end the hand is drawn, metres.
        waiting: How long the hand may take to come after, once it is drawn no further, seconds.
        free_stiffness: Of the arm while nothing is held, newtons per metre.
        held_stiffness: Of the arm along the path, newtons per metre.
        smoothing: Time constant of the filter on force, seconds.
        held_force: Force above which a handle is held, newtons, if the hand is also held up.
        held_pace: Share of the drag's speed below which the hand is held up; a handle that comes along is not held.
        held_for: How long both have to last, seconds.
        enough: Progress from which on the handle has come along; force no longer counts.
        landing_force: Force along the axis at which the descent is given up, newtons.
    """

    clearance: float = 0.05
    descent: float = 0.25
    lift_ramp: float = 2.0
    settling: float = 0.08
    taring: float = 0.06
    drag: float = 0.08
    ramp: float = 0.6
    overdrive: float = 0.006
    waiting: float = 0.3
    free_stiffness: float = 2500.0
    held_stiffness: float = 1500.0
    smoothing: float = 0.02
    held_force: float = 10.0
    held_pace: float = 0.6
    held_for: float = 0.05
    enough: float = 0.8
    landing_force: float = 25.0

    def attempt(self, arm: Arm, path: Path) -> Touch:
        """Try to bring a handle to the other end of its path, and go home.

        Args:
            arm: At home.
            path: Of the handle, as the robot believes it to be, from where the handle is.

        Raises:
            PlantFault: If the arm does not get to where it is sent.
        """
        verdict: Verdict
        began = arm.time
        start, _ = path.at(0.0)
        above = start - self.clearance * path.axis
        arm.reach(above, path.axis)
        zero = self._tare(arm, above)
        verdict, peak, progress = "failed", 0.0, 0.0
        if self._descend(arm, start, path.axis, zero):
            verdict, peak, progress = self._drag(arm, path, zero)
        self._retreat(arm, path.axis)
        arm.home()
        return Touch(verdict=verdict, peak_force=peak, progress=progress, seconds=arm.time - began)

    def _tare(self, arm: Arm, above: Vector) -> Vector:
        """What the sensor reads where nothing is touched."""
        self._stand(arm, above, self.settling, self.free_stiffness)
        readings = []
        for _ in range(self._periods(self.taring, arm)):
            self._stand(arm, above, arm.period, self.free_stiffness)
            readings.append(arm.force())
        return np.asarray(np.mean(readings, axis=0))

    def _descend(self, arm: Arm, start: Vector, axis: Vector, zero: Vector) -> bool:
        """Whether the hand comes down over the handle without landing on something."""
        height, speed, felt = self.clearance, 0.0, 0.0
        while height > 0:
            braking = math.sqrt(2 * self.lift_ramp * height)
            speed = min(speed + self.lift_ramp * arm.period, self.descent, braking, height / arm.period)
            arm.follow(start - height * axis, speed * axis, stiffness=self.free_stiffness)
            height -= max(speed, _CREEP) * arm.period
            felt = self._smoothed(felt, float((zero - arm.force()) @ axis), arm.period)
            if felt > self.landing_force:
                return False
        self._stand(arm, start, self.settling, self.held_stiffness)
        return True

    def _drag(self, arm: Arm, path: Path, zero: Vector) -> tuple[Verdict, float, float]:
        """Verdict, peak force, progress."""
        origin = path.travelled(arm.position())
        end = path.length + self.overdrive
        drawn, speed, pace, felt, peak, held, waited = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        before = origin
        while True:
            point, direction = path.at(drawn)
            speed = min(speed + self.ramp * arm.period, self.drag, (end - drawn) / arm.period)
            arm.follow(point, speed * direction, stiffness=self.held_stiffness)
            drawn += speed * arm.period
            travelled = path.travelled(arm.position())
            progress = (travelled - origin) / path.length
            pace, before = self._smoothed(pace, (travelled - before) / arm.period, arm.period), travelled
            _, along = path.at(travelled)
            felt = self._smoothed(felt, float((zero - arm.force()) @ along), arm.period)
            if progress < self.enough:
                peak = max(peak, felt)
                held = held + arm.period if felt > self.held_force and pace < self.held_pace * self.drag else 0.0
                if held >= self.held_for - 1e-9:
                    return "blocked", peak, progress
            if drawn >= end - 1e-9:
                if progress >= 1.0:
                    return "moved", peak, progress
                waited += arm.period
                if waited >= self.waiting:
                    return ("moved" if progress >= self.enough else "failed"), peak, progress

    def _retreat(self, arm: Arm, axis: Vector) -> None:
        """Let go of what is held, then up."""
        point = arm.position()
        self._stand(arm, point, self.settling, self.free_stiffness)
        point, height, speed = arm.position(), 0.0, 0.0
        while height < self.clearance:
            speed = min(speed + self.lift_ramp * arm.period, self.descent)
            arm.follow(point - height * axis, -speed * axis, stiffness=self.free_stiffness)
            height += speed * arm.period

    def _stand(self, arm: Arm, point: Vector, seconds: float, stiffness: float) -> None:
        for _ in range(self._periods(seconds, arm)):
            arm.follow(point, np.zeros(3), stiffness=stiffness)

    def _smoothed(self, before: float, now: float, period: float) -> float:
        return before + (now - before) * period / (self.smoothing + period)

    def _periods(self, seconds: float, arm: Arm) -> int:
        return max(1, round(seconds / arm.period))
