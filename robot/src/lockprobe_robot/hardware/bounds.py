"""Safety bounds around any arm: workspace, speed, force, a watchdog, the operator's consent, a log of commands.

Calls of drivers, which may fail or hang, end in a ``PlantFault``.

Software bounds catch programming errors. They do not replace the robot's own limits, its emergency stop, or a person
who watches.
"""

from __future__ import annotations

import json
import queue
import threading
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Final, TypeVar

import numpy as np

from lockprobe.foundation.errors import BadValue, LockprobeError, PlantFault, kind_and_words
from lockprobe.foundation.storage.atomic_file import writing
from lockprobe.plants.manual import Operator
from lockprobe.trial.record import Fact
from lockprobe_robot.arm.protocol import StoppableArm, Vector

_T = TypeVar("_T")

_STOP_SECONDS: Final = 2.0
"""Longest wait for the answer to a stop, seconds."""

_SLACK: Final = 0.02
"""Distance by which the measured tool may lie outside the workspace, metres: springs give way."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Bounds:
    """The limits of an arm.

    Attributes:
        low: Corner of the workspace box with the smallest coordinates, metres in the frame of the arm's base.
        high: The opposite corner.
        speed: Highest commanded speed of the tool, metres per second.
        force: Highest change of the force on the hand relative to free air, newtons.
        answer: Watchdog: longest duration of a command, and longest gap between commands of one move, seconds.
        motion: Longest duration of a free motion, seconds.

    Raises:
        BadValue: If the box is empty, or a limit is not positive.
    """

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    speed: float = 0.3
    force: float = 40.0
    answer: float = 0.5
    motion: float = 30.0

    def __post_init__(self) -> None:
        if not all(least < most for least, most in zip(self.low, self.high, strict=True)):
            raise BadValue("workspace", (self.low, self.high), "a box whose high corner is above its low corner")
        for name in ("speed", "force", "answer", "motion"):
            if not 0 < (value := getattr(self, name)) < float("inf"):
                raise BadValue(name, value, "a number above 0")


class Bounded:
    """A wrapper around an arm that enforces its bounds; itself a ``StoppableArm``.

    After any fault, the arm is told to stop before the error is raised. Before the first motion, and before the first
    motion after a stop, the operator has to agree.

    Args:
        operator: The person who agrees to motions.
        log: A file to which every command is added, as a line of JSON; None for none.
        clock: A monotonic clock, seconds; tests pass a fake one.

    Attributes:
        period: Duration of one call of :meth:`follow`, seconds.
        facts: What the arm says of itself, and the limits, for the record.
        stops: Number of stops so far.
        commands: Number of commands of a move, :meth:`follow`.
        late: Those of them that took longer than 1.5 periods.

    Raises:
        BadFile: If the log cannot be written.
    """

    def __init__(
        self,
        arm: StoppableArm,
        bounds: Bounds,
        operator: Operator,
        *,
        log: Path | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._arm, self._bounds, self._operator, self._clock, self.period = arm, bounds, operator, clock, arm.period
        corners = " to ".join("/".join(f"{number:g}" for number in corner) for corner in (bounds.low, bounds.high))
        self.facts: Mapping[str, Fact] = {
            **getattr(arm, "facts", {}),
            "workspace": corners,
            "speed_limit": bounds.speed,
            "force_limit": bounds.force,
        }
        self._file: IO[str] | None = None
        if log is not None:
            with writing(log):
                self._file = log.open("a", encoding="utf-8", buffering=1)
        self._thread = DriverThread()
        self._agreed = False
        self._free: Vector | None = None
        self._last: float | None = None
        self.stops, self.commands, self.late = 0, 0, 0

    @property
    def time(self) -> float:
        """Seconds since a fixed moment, by the arm's clock."""
        return self._arm.time

    def home(self) -> None:
        """Go to the homing pose; raises as every command."""
        self._begin("home")
        self._call("home", self._arm.home, self._bounds.motion)

    def reach(self, position: Vector, axis: Vector) -> None:
        """Go to a pose in the workspace.

        Raises:
            PlantFault: If the pose lies outside, the operator does not agree, or the arm fails.
        """
        self._begin("reach", position=_plain(position), axis=_plain(axis))
        self._inside("a pose is", position)
        self._call("reach", lambda: self._arm.reach(position, axis), self._bounds.motion)
        self._inside("the tool is", self.position(), _SLACK)

    def follow(self, position: Vector, velocity: Vector, *, stiffness: float) -> None:
        """Follow a moving point for one period.

        Raises:
            PlantFault: If the target, the tool, the speed or the force leaves the bounds, commands of a move come too
                late (watchdog), or the arm fails.
        """
        bounds, now = self._bounds, self._clock()
        gap = 0.0 if self._last is None else now - self._last
        self._begin("follow", position=_plain(position), velocity=_plain(velocity), stiffness=stiffness)
        if gap > bounds.answer:
            self.fault(f"no command came for {gap:.2f} s in the middle of a move, at most {bounds.answer:g} s")
        self._inside("a target is", position + self.period * velocity)
        if (speed := float(np.linalg.norm(velocity))) > bounds.speed + 1e-9:
            self.fault(f"a speed of {speed:.2f} m/s was commanded, at most {bounds.speed:g} m/s")
        self._call("follow", lambda: self._arm.follow(position, velocity, stiffness=stiffness), bounds.answer)
        self._last = self._clock()
        self.commands += 1
        self.late += self._last - now > 1.5 * self.period
        self._inside("the tool is", self.position(), _SLACK)
        force = self.force()
        if not np.isfinite(force).all():
            self.fault("the force is not a number")
        if self._free is None:
            self._free = np.array(force)
        if (felt := float(np.linalg.norm(force - self._free))) > bounds.force:
            self.fault(f"the hand feels {felt:.1f} N, at most {bounds.force:g} N")

    def position(self) -> Vector:
        """Position of the tool, metres."""
        return self._call("position", self._arm.position, self._bounds.answer)

    def force(self) -> Vector:
        """Mean force on the hand over the last period, newtons."""
        return self._call("force", self._arm.force, self._bounds.answer)

    def stop(self) -> None:
        """Stop the arm; the operator then has to agree to the next motion. It raises nothing."""
        self._log("stop")
        self.stops += 1
        self._agreed, self._last, self._free = False, None, None
        try:
            DriverThread().call("stop", self._arm.stop, _STOP_SECONDS)  # the arm's thread may hang
        except PlantFault as fault:
            self._log("stop failed", why=str(fault))

    def close(self) -> None:
        """Stop the arm, and close the log."""
        self.stop()
        if self._file is not None:
            self._file.close()
            self._file = None

    def fault(self, why: str) -> None:
        """Stop the arm, and raise ``PlantFault``."""
        self.stop()
        raise PlantFault(why)

    def _log(self, command: str, **facts: object) -> None:
        if self._file is not None:
            self._file.write(json.dumps({"t": round(time.time(), 4), "command": command, **facts}) + "\n")

    def _begin(self, command: str, **facts: object) -> None:
        """Log a command, and ask the operator if it is the first motion since a stop."""
        self._log(command, **facts)
        if command != "follow":
            self._last, self._free = None, None
        if self._agreed:
            return
        question = "The arm is about to move. Is everybody clear of it, and is the stop button at hand? y/n:"
        try:
            agreed = self._operator.ask(question, ("y", "n")) == "y"
        except PlantFault:
            self.stop()
            raise
        if not agreed:
            self.fault("the operator did not agree to a motion")
        self._agreed = True

    def _inside(self, what: str, point: Vector, slack: float = 0.0) -> None:
        low, high = np.asarray(self._bounds.low) - slack, np.asarray(self._bounds.high) + slack
        if not ((low <= point) & (point <= high)).all():
            said = "/".join(f"{number:.3f}" for number in point)
            self.fault(f"{what} at {said} m, outside the workspace {self.facts['workspace']} m")

    def _call(self, what: str, work: Callable[[], _T], seconds: float) -> _T:
        try:
            return self._thread.call(f"the arm, {what}", work, seconds)
        except (PlantFault, KeyboardInterrupt):
            self.stop()
            raise


def _plain(vector: Vector) -> list[float]:
    return [round(float(number), 5) for number in vector]


def call_driver(what: str, work: Callable[[], _T]) -> _T:
    """Call a driver in this thread; ``what`` names the device in messages.

    Raises:
        PlantFault: If it raises anything; Lockprobe's own errors pass unchanged.
    """
    try:
        return work()
    except LockprobeError:
        raise
    except Exception as error:
        raise PlantFault(f"{what}: {kind_and_words(error)}") from error


class DriverThread:
    """A daemon thread that calls one driver, so that a hanging call can be abandoned.

    It never keeps the process alive. After a time-out, every further call is refused.
    """

    def __init__(self) -> None:
        self._work: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._hangs = ""
        threading.Thread(target=self._serve, daemon=True, name="driver").start()

    def call(self, what: str, work: Callable[[], _T], seconds: float) -> _T:
        """Call a driver with a time-out.

        Raises:
            PlantFault: If the call takes longer, raises, or an earlier call still hangs.
        """
        if self._hangs:
            raise PlantFault(f"{what}: an earlier call hangs ({self._hangs})")
        answer: Future[_T] = Future()

        def run() -> None:
            try:
                answer.set_result(call_driver(what, work))
            except LockprobeError as error:
                answer.set_exception(error)

        self._work.put(run)
        try:
            return answer.result(seconds)
        except TimeoutError:
            self._hangs = what
            raise PlantFault(f"{what}: no answer within {seconds:g} s") from None

    def _serve(self) -> None:
        while True:
            self._work.get()()
