"""Rehearsals: the adapter of a robot, everything but the robot. A ladder of three rungs before the first real motion.

* ``scripted``: an arm without a body; the whole program runs, in milliseconds.
* ``twin``: the simulated arm and box in this process.
* ``wire``: Franka's real client library, over loopback, to a process that plays the robot with the same arm and box.

Every rung drives the same :class:`~lockprobe.plants.hardware.rig.Rig`, bounds and guarded move.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from lockprobe.errors import BadValue, PlantFault
from lockprobe.lockbox.box import Configuration, Lockbox, bits
from lockprobe.plants.arm.guarded_move import GuardedMove, HandlePath
from lockprobe.plants.arm.protocol import StoppableArm
from lockprobe.plants.handle_path import handle_path
from lockprobe.plants.hardware.bounds import Bounded, Bounds
from lockprobe.plants.hardware.rig import Rig
from lockprobe.plants.hardware.scripted_arm import ScriptedArm
from lockprobe.plants.operator import ConsentingOperator
from lockprobe.plants.rehearsal_settings import RehearsalRung
from lockprobe.plants.scene.panel import lay_out_panel
from lockprobe.record import Fact

__all__ = [
    "BOUNDS",
    "RUNGS",
    "Attempted",
    "Parts",
    "Rehearsal",
    "parts_of",
    "rehearse",
    "rehearse_rig",
]

RUNGS: Mapping[RehearsalRung, str] = {
    "scripted": "an arm without a body",
    "twin": "the simulated arm, in this process",
    "wire": "the real client library, over loopback, to a simulated robot",
}
"""The rungs from the bottom, and what each is."""

BOUNDS = Bounds(low=(0.0, -0.6, 0.02), high=(0.85, 0.6, 0.9), answer=2.0)
"""The workspace of rehearsals. A busy machine may need two seconds for an answer; a robot may not."""

_FREE_SPEED = 0.5
"""Share of the highest speed in free motions over the wire."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Parts:
    """What a rung consists of.

    Attributes:
        arm: The arm.
        path: The way of a handle: joint by index in panel order, position now.
        state: Where the joints stand, once they rest.
        put: Puts them elsewhere, as a person would between attempts.
        close: Lets go of everything.
        facts: What it is.
        figures: How it kept time; empty where time is simulated.
    """

    arm: StoppableArm
    path: Callable[[int, bool], HandlePath]
    state: Callable[[], Configuration]
    put: Callable[[Configuration], None]
    close: Callable[[], None] = lambda: None
    facts: Mapping[str, Fact] = field(default_factory=dict)
    figures: Callable[[], Mapping[str, int]] = dict


@dataclass(frozen=True, slots=True, kw_only=True)
class Attempted:
    """One rehearsed attempt.

    Attributes:
        state: The configuration before, a bit string in panel order.
        joint: Name of the joint.
        free: Whether the rules let it move.
        verdict: The robot's judgement; empty if a fault ended the attempt.
        true: Whether the joints afterwards stand as the rules have it.
        peak_force: Newtons.
        fault: What ended the attempt; empty if nothing did.
    """

    state: str
    joint: str
    free: bool
    verdict: str = ""
    true: bool = False
    peak_force: float = math.nan
    fault: str = ""

    @property
    def right(self) -> bool:
        """Whether verdict and truth are those of the rules."""
        return self.true and self.verdict == ("moved" if self.free else "blocked")


@dataclass(frozen=True, slots=True, kw_only=True)
class Rehearsal:
    """A rehearsal.

    Attributes:
        rung: How real it was.
        box: Name of the box.
        attempts: All attempts, in order.
        commands_late: Commands of a move that took longer than 1.5 periods of wall time.
        figures: How a simulated robot kept time: ``ticks`` of 1 ms, and those ``late``; else empty.
        facts: What the parts are.
    """

    rung: RehearsalRung
    box: str
    attempts: tuple[Attempted, ...]
    commands_late: int
    figures: Mapping[str, int]
    facts: Mapping[str, Fact]

    @property
    def right(self) -> int:
        """Attempts whose verdict and truth are those of the rules."""
        return sum(one.right for one in self.attempts)


def parts_of(rung: str, box: Lockbox, labels: tuple[str, ...], rng: np.random.Generator) -> Parts:
    """The parts of a rung, with the box in its initial configuration.

    Raises:
        BadValue: If there is no such rung.
        Missing: If a package is missing.
        PlantFault: If a process does not start.
    """
    if rung == "scripted":
        path = partial(handle_path, lay_out_panel(box))
        scripted = ScriptedArm(box, path)
        return Parts(
            arm=scripted,
            path=path,
            state=lambda: scripted.configuration,
            put=lambda configuration: setattr(scripted, "configuration", configuration),
        )
    if rung == "twin":
        return _twin(box, labels, rng)
    if rung == "wire":
        return _wire(box, labels, rng)
    raise BadValue("rung", rung, f"one of {', '.join(RUNGS)}")


def rehearse_rig(rung: str, box: Lockbox, labels: tuple[str, ...], rng: np.random.Generator) -> Rig:
    """A rig on a rung, as a plant: ``--plant 'rig?rung=wire'``. Nobody has to agree, because nothing real moves.

    Raises:
        UserMistake: If the rung cannot be had here.
        PlantFault: If a process does not start.
    """
    parts, operator = parts_of(rung, box, labels, rng), ConsentingOperator()
    return Rig(
        box,
        labels=labels,
        arm=Bounded(parts.arm, BOUNDS, operator),
        path=parts.path,
        operator=operator,
        truth="simulation",
        rung=rung,  # type: ignore[arg-type] # parts_of knows no other
        facts=parts.facts,
        state=parts.state,
        release=parts.close,
    )


def rehearse(
    rung: RehearsalRung,
    box: Lockbox,
    *,
    attempts: int,
    seed: int = 1,
    tell: Callable[[Attempted], None] = lambda attempted: None,
) -> Rehearsal:
    """Attempt random joints from random configurations, and compare every verdict with the rules.

    After a fault the arm is told to stop, and new parts take over.

    Args:
        rung: How real it is.
        box: The box.
        attempts: How many attempts.
        seed: Of configurations and joints. All rungs make the same attempts.
        tell: Called after every attempt.

    Raises:
        UserMistake: If the rung cannot be had here.
        PlantFault: If a process does not start.
    """
    luck, labels = np.random.default_rng(seed), tuple("ABCDEFGH"[: len(box.joints)])
    looks = luck.spawn(1)[0]
    made: list[Attempted] = []
    late, figures, facts = 0, Counter[str](), dict[str, Fact]()
    while len(made) < attempts:
        parts = parts_of(rung, box, labels, looks)
        arm = Bounded(parts.arm, BOUNDS, ConsentingOperator())
        try:
            arm.home()
            while len(made) < attempts:
                before = tuple(bool(at) for at in luck.integers(2, size=len(box.joints)))
                made.append(_attempted(parts, arm, box, before, int(luck.integers(len(box.joints)))))
                tell(made[-1])
                if made[-1].fault:
                    break  # the hand may hold a handle: begin again with new parts
            figures.update(parts.figures())
        finally:
            arm.stop()
            parts.close()
            late, facts = late + arm.late, dict(parts.facts)
    return Rehearsal(
        rung=rung, box=box.name, attempts=tuple(made), commands_late=late, figures=dict(figures), facts=facts
    )


def _attempted(parts: Parts, arm: Bounded, box: Lockbox, before: Configuration, joint: int) -> Attempted:
    after, free = box.attempt(before, joint)
    made = Attempted(state=bits(before), joint=box.names[joint], free=free)
    try:
        parts.put(before)
        touch = GuardedMove().attempt(arm, parts.path(joint, before[joint]))
        return Attempted(
            state=made.state,
            joint=made.joint,
            free=free,
            verdict=touch.verdict,
            true=parts.state() == after,
            peak_force=touch.peak_force,
        )
    except PlantFault as fault:
        arm.stop()
        return Attempted(state=made.state, joint=made.joint, free=free, fault=str(fault))


def _twin(box: Lockbox, labels: tuple[str, ...], rng: np.random.Generator) -> Parts:
    from lockprobe.plants.catalogue import require_mujoco

    require_mujoco()
    from lockprobe.plants.twin import Twin
    from lockprobe.plants.twin_settings import TwinSettings

    twin = Twin(box, labels=labels, settings=TwinSettings(), rng=rng)
    path = partial(handle_path, twin.panel)
    facts = {"engine": twin.facts["engine"]}
    return Parts(arm=twin.arm, path=path, state=twin.settled, put=twin.put, close=twin.close, facts=facts)


def _wire(box: Lockbox, labels: tuple[str, ...], rng: np.random.Generator) -> Parts:
    from lockprobe.plants.catalogue import require_mujoco

    require_mujoco()
    from lockprobe.plants.hardware.driver_call import call_driver
    from lockprobe.plants.hardware.franky import FrankyArm
    from lockprobe.plants.hardware.wire_server import SimulatedRobot
    from lockprobe.plants.hardware.wrench import FreshWrench
    from lockprobe.plants.scene.bolts import case_depth
    from lockprobe.plants.scene.gates import gates_of

    robot = SimulatedRobot(box, labels, int(rng.integers(2**31)))
    wrench = FreshWrench(reader=robot, oldest=0.1)  # a busy machine; the default of a real sensor is 20 ms
    arm = call_driver("the connection", lambda: FrankyArm(robot.host, wrench=wrench, speed=_FREE_SPEED))

    def figures() -> Mapping[str, int]:
        kept = robot.figures()
        return {"ticks": kept.ticks, "late": kept.late}

    path = partial(handle_path, lay_out_panel(box, depth=case_depth(gates_of(box))))
    facts = {**arm.facts, "robot": robot.version}
    return Parts(
        arm=arm, path=path, state=robot.configuration, put=robot.put, close=robot.close, facts=facts, figures=figures
    )
