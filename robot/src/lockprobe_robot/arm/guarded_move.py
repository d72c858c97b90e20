"""The guarded move: an arm attempts a joint, measures forces and judges whether the joint moved (paper, Sec. 2.1).

The hand moves above the handle, holds still to tare the force sensor, descends until it holds the handle, drags it
along its path while monitoring force and progress, rises and goes home. The same code moves a simulated arm, a real
one, and a scripted one in tests. The sensor is tared before any contact. Otherwise the pressure of a handle on the hand
would count as zero, and all later forces would be too large.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lockprobe_robot.arm.protocol import Arm, Vector

TouchVerdict = Literal["moved", "blocked", "failed"]
"""The robot's judgement: the handle came along, it was held, or the hand never got over it."""

_CREEP = 0.01
"""Least assumed speed of a descent, metres per second, so that it ends."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Touch:
    """The measurements and the verdict of one guarded move.

    Attributes:
        verdict: The robot's verdict.
        peak_force: Largest filtered force against the drag, newtons.
        progress: Fraction of the path that the hand travelled.
        seconds: Duration from home to home by the arm's clock.
    """

    verdict: TouchVerdict
    peak_force: float
    progress: float
    seconds: float

    def as_facts(self) -> Mapping[str, str | float]:
        """The fields as facts for a record, with numbers rounded to six digits."""
        facts = asdict(self)
        return {name: fact if isinstance(fact, str) else round(fact, 6) for name, fact in facts.items()}


@dataclass(frozen=True, slots=True, kw_only=True)
class GuardedMove:
    """The guarded move: its motion parameters and the thresholds of its verdict.

    Attributes:
        clearance: Approach and retreat height above the handle, metres.
        descent: Vertical speed down and up, metres per second.
        lift_ramp: Vertical acceleration, metres per second squared.
        settling: Time to come to rest above the handle, around it, and after release, seconds.
        taring: Averaging time of the sensor's zero, seconds.
        closing: Speed along the path until the hand feels the handle, metres per second. The arm is heavy: at the speed
            of the drag it would hit a locked handle with 30 N.
        touched: Force at which the hand feels the handle, newtons.
        drag: Speed along the path from then on, metres per second. It falls from half of ``held_force`` on, so that a
            pull ends where it is judged.
        creep: Share of that speed that is left at ``held_force``.
        ramp: Acceleration along the path, metres per second squared.
        overdrive: Distance that the target moves beyond the end of the path, metres.
        waiting: Time for the hand to catch up after the target stops, seconds.
        free_stiffness: Cartesian stiffness in free motion, newtons per metre.
        held_stiffness: Cartesian stiffness during the drag, newtons per metre.
        smoothing: Time constant of the low-pass filter on force, seconds.
        held_force: A handle counts as held if the force exceeds this, newtons,
        held_pace: and the hand is slower than this share of what it is drawn at,
        held_for: both for this long, seconds.
        enough: Progress, [0, 1], above which the handle counts as moved whatever the force.
        landing_force: Force along the axis at which the descent is aborted, newtons.
    """

    clearance: float = 0.05
    descent: float = 0.25
    lift_ramp: float = 2.0
    settling: float = 0.08
    taring: float = 0.06
    closing: float = 0.03
    touched: float = 1.0
    drag: float = 0.08
    creep: float = 0.1
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

    def attempt(self, arm: Arm, path: HandlePath) -> Touch:
        """Try to drag a handle to the other end of its path, then go home.

        Args:
            arm: An arm that is at home.
            path: The handle's path as estimated by the robot, starting at the handle.

        Raises:
            PlantFault: If the arm does not reach a pose.
        """
        verdict: TouchVerdict
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
        """Tare: the sensor's mean reading without contact."""
        self._stand(arm, above, self.settling, self.free_stiffness)
        readings = []
        for _ in range(self._periods(self.taring, arm)):
            self._stand(arm, above, arm.period, self.free_stiffness)
            readings.append(arm.force())
        return np.asarray(np.mean(readings, axis=0))

    def _descend(self, arm: Arm, start: Vector, axis: Vector, zero: Vector) -> bool:
        """Lower the hand over the handle; False if it landed on something."""
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

    def _drag(self, arm: Arm, path: HandlePath, zero: Vector) -> tuple[TouchVerdict, float, float]:
        """Drag the handle along its path: verdict, peak force, progress."""
        origin = path.travelled(arm.position())
        end = path.length + self.overdrive
        drawn, speed, pace, felt, peak, held, waited = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        touched = False
        before = origin
        while True:
            point, direction = path.at(drawn)
            touched = touched or felt > self.touched
            eased = min(max(2 - 2 * felt / self.held_force, self.creep), 1.0)
            most = self.drag * eased if touched else self.closing
            speed = min(speed + self.ramp * arm.period, most, (end - drawn) / arm.period)
            arm.follow(point, speed * direction, stiffness=self.held_stiffness)
            drawn += speed * arm.period
            travelled = path.travelled(arm.position())
            progress = (travelled - origin) / path.length
            pace, before = self._smoothed(pace, (travelled - before) / arm.period, arm.period), travelled
            _, along = path.at(travelled)
            felt = self._smoothed(felt, float((zero - arm.force()) @ along), arm.period)
            if progress < self.enough:
                peak = max(peak, felt)
                held = held + arm.period if felt > self.held_force and pace < self.held_pace * speed else 0.0
                if held >= self.held_for - 1e-9:
                    return "blocked", peak, progress
            if drawn >= end - 1e-9:
                if progress >= 1.0:
                    return "moved", peak, progress
                waited += arm.period
                if waited >= self.waiting:
                    return ("moved" if progress >= self.enough else "failed"), peak, progress

    def _retreat(self, arm: Arm, axis: Vector) -> None:
        """Release the handle, then rise."""
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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HandlePath:
    """The path of a handle: a polyline parametrised by arc length.

    Attributes:
        points: Shape (n, 3) with n > 1, metres; no two neighbours are equal.
        axis: Direction in which a hand on the handle points, a unit vector of shape (3,).
    """

    points: NDArray[np.float64]
    axis: Vector
    _along: NDArray[np.float64] = field(init=False, repr=False)
    _directions: NDArray[np.float64] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        steps = np.diff(self.points, axis=0)
        lengths = np.linalg.norm(steps, axis=1)
        object.__setattr__(self, "_along", np.concatenate([[0.0], np.cumsum(lengths)]))
        object.__setattr__(self, "_directions", steps / lengths[:, None])

    @property
    def length(self) -> float:
        """Length in metres."""
        return float(self._along[-1])

    def at(self, distance: float) -> tuple[Vector, Vector]:
        """The point at a distance from the start, and the path's direction there.

        Args:
            distance: Metres; before the start and beyond the end the path continues straight.
        """
        last = len(self._directions) - 1
        piece = min(max(int(np.searchsorted(self._along, distance, side="right")) - 1, 0), last)
        direction = self._directions[piece]
        return self.points[piece] + (distance - self._along[piece]) * direction, direction

    def travelled(self, point: Vector) -> float:
        """Arc length of the path's nearest point to a point, metres; it may lie before the start or beyond the end."""
        ahead = np.einsum("ij,ij->i", point - self.points[:-1], self._directions)
        spans = np.diff(self._along)
        inside = np.clip(ahead, 0.0, spans)
        gaps = np.linalg.norm(self.points[:-1] + inside[:, None] * self._directions - point, axis=1)
        piece = int(np.argmin(gaps))
        ends = (piece == 0 and ahead[piece] < 0) or (piece == len(spans) - 1 and ahead[piece] > spans[piece])
        return float(self._along[piece] + (ahead if ends else inside)[piece])
