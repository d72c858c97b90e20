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
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from lockprobe_robot.arm.protocol import StoppableArm, Vector

TouchVerdict = Literal["moved", "blocked", "failed"]
"""The robot's judgement: the handle came along, it was held, or the hand never got over it."""

CLEARANCE: Final = 0.05
"""Approach and retreat height above the handle, metres."""

_DESCENT, _LIFT_RAMP, _CREEP = 0.25, 2.0, 0.01
"""Vertical speed, metres per second; acceleration; least assumed speed of a descent, so that it ends."""

_SETTLING, _TARING = 0.08, 0.06
"""Time to come to rest above the handle, around it, and after release; averaging time of the sensor's zero; seconds."""

_CLOSING, _TOUCHED = 0.03, 1.0
"""Speed along the path, metres per second, until the hand feels the handle, which it does at this force, newtons. The
arm is heavy: at the speed of the drag it would hit a locked handle with 30 N."""

_DRAG, _EASED, _RAMP = 0.08, 0.1, 0.6
"""Speed along the path from then on; it falls from half of ``HELD_FORCE`` on to this share there, so that a pull ends
where it is judged; acceleration, metres per second squared."""

_OVERDRIVE, _WAITING = 0.006, 0.3
"""Metres that the target moves beyond the end of the path; seconds for the hand to catch up after it stops."""

FREE_STIFFNESS, HELD_STIFFNESS = 2500.0, 1500.0
"""Cartesian stiffness in free motion and during the drag, newtons per metre."""

_SMOOTHING = 0.02
"""Time constant of the low-pass filter on force, seconds."""

HELD_FORCE, _HELD_PACE, _HELD_FOR = 10.0, 0.6, 0.05
"""A handle counts as held if the force exceeds this, newtons, and the hand is slower than this share of what it is
drawn at, both for this long, seconds."""

_ENOUGH = 0.8
"""Progress, [0, 1], above which the handle counts as moved whatever the force."""

_LANDING_FORCE = 25.0
"""Force along the axis at which the descent is aborted, newtons."""


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


def guarded_move(arm: StoppableArm, path: HandlePath) -> Touch:
    """Try to drag a handle to the other end of its path as the robot believes it, from home, then go home.

    Raises:
        PlantFault: If the arm does not reach a pose.
    """
    began = arm.time
    start, _ = path.at(0.0)
    above = start - CLEARANCE * path.axis
    arm.reach(above, path.axis)
    _stand(arm, above, _SETTLING, FREE_STIFFNESS)
    readings = []
    for _ in range(_periods(_TARING, arm)):
        _stand(arm, above, arm.period, FREE_STIFFNESS)
        readings.append(arm.force())
    zero: Vector = np.mean(readings, axis=0)
    verdict: TouchVerdict = "failed"
    peak, progress = 0.0, 0.0
    height, speed, felt = CLEARANCE, 0.0, 0.0
    while height > 0 and felt <= _LANDING_FORCE:
        braking = math.sqrt(2 * _LIFT_RAMP * height)
        speed = min(speed + _LIFT_RAMP * arm.period, _DESCENT, braking, height / arm.period)
        arm.follow(start - height * path.axis, speed * path.axis, stiffness=FREE_STIFFNESS)
        height -= max(speed, _CREEP) * arm.period
        felt = _smoothed(felt, float((zero - arm.force()) @ path.axis), arm.period)
    if felt <= _LANDING_FORCE:  # else the hand landed on something
        _stand(arm, start, _SETTLING, HELD_STIFFNESS)
        verdict, peak, progress = _drag(arm, path, zero)
    _stand(arm, arm.position(), _SETTLING, FREE_STIFFNESS)
    point, height, speed = arm.position(), 0.0, 0.0
    while height < CLEARANCE:
        speed = min(speed + _LIFT_RAMP * arm.period, _DESCENT)
        arm.follow(point - height * path.axis, -speed * path.axis, stiffness=FREE_STIFFNESS)
        height += speed * arm.period
    arm.home()
    return Touch(verdict=verdict, peak_force=peak, progress=progress, seconds=arm.time - began)


def _drag(arm: StoppableArm, path: HandlePath, zero: Vector) -> tuple[TouchVerdict, float, float]:
    """Drag the handle along its path: verdict, peak force, progress."""
    origin = path.travelled(arm.position())
    end = path.length + _OVERDRIVE
    drawn, speed, pace, felt, peak, held, waited = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    touched = False
    before = origin
    while True:
        point, direction = path.at(drawn)
        touched = touched or felt > _TOUCHED
        eased = min(max(2 - 2 * felt / HELD_FORCE, _EASED), 1.0)
        most = _DRAG * eased if touched else _CLOSING
        speed = min(speed + _RAMP * arm.period, most, (end - drawn) / arm.period)
        arm.follow(point, speed * direction, stiffness=HELD_STIFFNESS)
        drawn += speed * arm.period
        travelled = path.travelled(arm.position())
        progress = (travelled - origin) / path.length
        pace, before = _smoothed(pace, (travelled - before) / arm.period, arm.period), travelled
        _, along = path.at(travelled)
        felt = _smoothed(felt, float((zero - arm.force()) @ along), arm.period)
        if progress < _ENOUGH:
            peak = max(peak, felt)
            held = held + arm.period if felt > HELD_FORCE and pace < _HELD_PACE * speed else 0.0
            if held >= _HELD_FOR - 1e-9:
                return "blocked", peak, progress
        if drawn >= end - 1e-9:
            if progress >= 1.0:
                return "moved", peak, progress
            waited += arm.period
            if waited >= _WAITING:
                return ("moved" if progress >= _ENOUGH else "failed"), peak, progress


def _stand(arm: StoppableArm, point: Vector, seconds: float, stiffness: float) -> None:
    for _ in range(_periods(seconds, arm)):
        arm.follow(point, np.zeros(3), stiffness=stiffness)


def _smoothed(before: float, now: float, period: float) -> float:
    return before + (now - before) * period / (_SMOOTHING + period)


def _periods(seconds: float, arm: StoppableArm) -> int:
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

        ``distance`` is in metres; before the start and beyond the end the path continues straight.
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
