"""Faults on the wire: what breaks, and what is said of it; and a rig over the wire that has one of them."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from hardware.fakes import Willing
from lockprobe_robot.hardware.bounds import Bounded, Bounds
from lockprobe_robot.hardware.rehearsal import BOUNDS, played_eye, rehearse_rig
from lockprobe_robot.hardware.rig import Rig
from lockprobe_robot.hardware.rungs import parts_of
from lockprobe_robot.rehearsal_settings import RehearsalSettings

from lockprobe.plants.operator import ConsentingOperator


def robot_of(parts):
    """The process behind the parts."""
    return parts.put.__self__


@dataclass(frozen=True)
class Fault:
    """What is said of a fault (``why``), and how to get it: ``now`` breaks something in the middle of a move."""

    why: str
    now: Callable = lambda parts, eye: None
    limits: dict = field(default_factory=dict)
    operator: Callable = ConsentingOperator
    truth: str = "simulation"
    alive: bool = True  # the robot can be asked afterwards whether it rests


FAULTS = {
    "server killed": Fault("the arm, |the wrench is", lambda parts, eye: robot_of(parts).process.kill(), alive=False),
    "frozen for 1 s": Fault("the wrench is|no answer", lambda parts, eye: robot_of(parts).freeze(1.0), {"answer": 0.3}),
    "frozen for 60 s": Fault(
        "the wrench is|no answer", lambda parts, eye: robot_of(parts).freeze(60.0), {"answer": 0.3}, alive=False
    ),
    "motion ended": Fault("the robot ended the motion", lambda parts, eye: parts.arm._robot.stop()),
    "wrench stale": Fault("^the wrench is [0-9]+ ms old, at most 100 ms", lambda parts, eye: robot_of(parts).mute()),
    "camera gone": Fault(
        "^the RealSense camera gives no picture", lambda parts, eye: eye.camera.unplug(), truth="camera"
    ),
    "workspace left": Fault("^a target at .* m lies outside the workspace", limits={"low": (0.0, -0.6, 0.21)}),
    "force limit": Fault("^the hand feels [0-9.]+ N, at most 2.5 N", limits={"force": 2.5}),
    "operator says no": Fault("^the operator did not agree to a motion", operator=lambda: Willing("", "n")),
}


class Once:
    """Breaks something at the 30th point that an arm is told to follow."""

    def __init__(self, arm, breaks):
        self._arm, self._breaks, self._points = arm, breaks, 0

    def __getattr__(self, name):
        return getattr(self._arm, name)

    def follow(self, position, velocity, *, stiffness):
        self._points += 1
        if self._points == 30:
            self._breaks()
        self._arm.follow(position, velocity, stiffness=stiffness)


def wire_rig(*, box, labels, rng):
    """A rig over the wire with the fault that ``BREAKING`` names; without one after it broke."""
    if labels == box.names:  # only checked, before the study
        return rehearse_rig(RehearsalSettings(), box, labels, rng)
    fault = FAULTS[BREAKING.pop()] if BREAKING else Fault("")
    parts = parts_of("wire", box, labels, rng)
    eye = played_eye(parts) if fault.truth == "camera" else None
    operator, limits = fault.operator(), {"low": BOUNDS.low, "high": BOUNDS.high, "answer": 2.0, **fault.limits}
    arm = Bounded(Once(parts.arm, lambda: fault.now(parts, eye)), Bounds(**limits), operator)
    MADE.append((arm, parts))
    state = parts.state if eye is None else None
    return Rig(
        box, labels=labels, arm=arm, path=parts.path, operator=operator, eye=eye, truth=fault.truth, rung="wire",
        facts=parts.facts, state=state, release=lambda: ended(fault, parts),
    )  # fmt: skip


wire_rig.attended = True
BREAKING, MADE, SPEEDS = [], [], []


def ended(fault, parts):
    """Before the process goes: how fast anything still moves, radians or metres per second."""
    if fault.alive:
        time.sleep(0.8)
        before = np.array(robot_of(parts).pose())
        time.sleep(0.1)
        SPEEDS.append(float(np.abs(robot_of(parts).pose() - before).max()) / 0.1)
    parts.close()
