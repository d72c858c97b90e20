"""Rehearsals: software-in-the-loop tests of a rig without the robot, on two rungs of increasing realism.

* ``scripted``: an arm without a body; the whole program runs in milliseconds.
* ``twin``: the simulated arm and box in this process.

Both drive the same :class:`~lockprobe_robot.hardware.rig.Rig`, bounds and guarded move; the simulation tells the truth.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from lockprobe.boxes.box import Configuration, Lockbox, bits
from lockprobe.foundation.errors import BadValue, PlantFault
from lockprobe.plants.catalogue import FilmHook
from lockprobe.plants.operator import ConsentingOperator
from lockprobe.trial.protocols import Plant
from lockprobe.trial.record import Fact
from lockprobe_robot.arm.guarded_move import GuardedMove, HandlePath
from lockprobe_robot.arm.protocol import StoppableArm
from lockprobe_robot.box_model.panel import lay_out_panel
from lockprobe_robot.hardware.bounds import Bounded, Bounds
from lockprobe_robot.hardware.rig import Rig
from lockprobe_robot.hardware.scripted_arm import ScriptedArm
from lockprobe_robot.plants import RehearsalRung
from lockprobe_robot.rendering.probe import require_mujoco

BOUNDS = Bounds(low=(0.0, -0.6, 0.02), high=(0.85, 0.6, 0.9), answer=2.0)
"""The workspace of rehearsals. A busy machine may need two seconds for an answer; a robot may not."""

RUNGS: Mapping[RehearsalRung, str] = {
    "scripted": "an arm without a body",
    "twin": "the simulated arm, in this process",
}
"""The rungs from the bottom, and what each is."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Parts:
    """The parts of a rung.

    Attributes:
        arm: The arm.
        path: Function from joint (index in panel order) and present position to the handle's path.
        state: The configuration, once the joints rest.
        put: Sets the configuration, as a person would between attempts.
        close: Releases everything.
        facts: Facts for the record.
    """

    arm: StoppableArm
    path: Callable[[int, bool], HandlePath]
    state: Callable[[], Configuration]
    put: Callable[[Configuration], None]
    close: Callable[[], None] = lambda: None
    facts: Mapping[str, Fact] = field(default_factory=dict)


def parts_of(
    rung: str, box: Lockbox, labels: tuple[str, ...], rng: np.random.Generator, film: FilmHook | None = None
) -> Parts:
    """The parts of a rung, with the box in its initial configuration; ``scripted`` cannot be filmed.

    Raises:
        BadValue: If there is no such rung.
        Missing: If a package is missing.
    """
    if rung == "scripted":
        path = lay_out_panel(box).handle_path
        scripted = ScriptedArm(box, path)
        return Parts(
            arm=scripted,
            path=path,
            state=lambda: scripted.configuration,
            put=lambda configuration: setattr(scripted, "configuration", configuration),
        )
    if rung == "twin":
        return _twin(box, labels, rng, film)
    raise BadValue("rung", rung, f"one of {', '.join(RUNGS)}")


def _twin(box: Lockbox, labels: tuple[str, ...], rng: np.random.Generator, film: FilmHook | None) -> Parts:
    require_mujoco()
    from lockprobe_robot.twin import Twin
    from lockprobe_robot.twin_settings import TwinSettings

    twin = Twin(box, labels=labels, settings=TwinSettings(), rng=rng, film=film)

    return Parts(
        arm=twin.arm,
        path=twin.panel.handle_path,
        state=twin.settled,
        put=twin.put,
        close=twin.close,
        facts={"engine": twin.facts["engine"]},
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class RehearsedAttempt:
    """One rehearsed attempt.

    Attributes:
        state: The configuration before, a bit string in panel order.
        joint: Name of the joint.
        free: Whether the rules let it move.
        verdict: The robot's verdict; empty if a fault ended the attempt.
        true: Whether the configuration afterwards follows the rules.
        peak_force: Newtons.
        fault: The fault that ended the attempt; empty without a fault.
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
        """Whether the verdict and the configuration agree with the rules."""
        return self.true and self.verdict == ("moved" if self.free else "blocked")


@dataclass(frozen=True, slots=True, kw_only=True)
class Rehearsal:
    """The result of a rehearsal.

    Attributes:
        rung: How real it was.
        box: Name of the box.
        attempts: All attempts, in order.
        commands_late: Commands of a move that took longer than 1.5 periods of wall time.
        facts: Facts about the parts, for the record.
    """

    rung: RehearsalRung
    box: str
    attempts: tuple[RehearsedAttempt, ...]
    commands_late: int
    facts: Mapping[str, Fact]

    @property
    def right(self) -> int:
        """Number of attempts whose verdict and configuration agree with the rules."""
        return sum(one.right for one in self.attempts)


def rehearse_rig(
    rung: RehearsalRung,
    box: Lockbox,
    labels: tuple[str, ...],
    rng: np.random.Generator,
    film: FilmHook | None = None,
) -> Plant:
    """A rig on a rung, as a plant: ``--plant 'rig?rung=twin'``. No operator has to agree: nothing real moves.

    Raises:
        UserMistake: If the rung is not available here.
    """
    parts, operator = parts_of(rung, box, labels, rng, film), ConsentingOperator()
    return Rig(
        box,
        labels=labels,
        arm=Bounded(parts.arm, BOUNDS, operator),
        path=parts.path,
        operator=operator,
        truth="simulation",
        rung=rung,
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
    tell: Callable[[RehearsedAttempt], None] = lambda attempted: None,
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
        UserMistake: If the rung is not available here.
    """
    luck, labels = np.random.default_rng(seed), tuple("ABCDEFGH"[: len(box.joints)])
    looks = luck.spawn(1)[0]
    made: list[RehearsedAttempt] = []
    late, facts = 0, dict[str, Fact]()
    while len(made) < attempts:
        parts = parts_of(rung, box, labels, looks)
        arm = Bounded(parts.arm, BOUNDS, ConsentingOperator())
        try:
            arm.home()
            while len(made) < attempts:
                before = tuple(bool(at) for at in luck.integers(2, size=len(box.joints)))
                made.append(_rehearsed_attempt(parts, arm, box, before, int(luck.integers(len(box.joints)))))
                tell(made[-1])
                if made[-1].fault:
                    break  # the hand may hold a handle: begin again with new parts
        finally:
            arm.stop()
            parts.close()
            late, facts = late + arm.late, dict(parts.facts)
    return Rehearsal(rung=rung, box=box.name, attempts=tuple(made), commands_late=late, facts=facts)


def _rehearsed_attempt(parts: Parts, arm: Bounded, box: Lockbox, before: Configuration, joint: int) -> RehearsedAttempt:
    after, free = box.attempt(before, joint)
    made = RehearsedAttempt(state=bits(before), joint=box.names[joint], free=free)
    try:
        parts.put(before)
        touch = GuardedMove().attempt(arm, parts.path(joint, before[joint]))
        return RehearsedAttempt(
            state=made.state,
            joint=made.joint,
            free=free,
            verdict=touch.verdict,
            true=parts.state() == after,
            peak_force=touch.peak_force,
        )
    except PlantFault as fault:
        arm.stop()
        return RehearsedAttempt(state=made.state, joint=made.joint, free=free, fault=str(fault))
