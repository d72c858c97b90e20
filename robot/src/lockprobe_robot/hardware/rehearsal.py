"""Rehearsals: software-in-the-loop tests of a rig without the robot, on two rungs of increasing realism.

* ``scripted``: an arm without a body; the whole program runs in milliseconds.
* ``twin``: the simulated arm and box in this process.

Both drive the same :class:`~lockprobe_robot.hardware.rig.Rig`, bounds and guarded move; the simulation tells the truth.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from lockprobe.boxes.box import Configuration, Lockbox, bits
from lockprobe.foundation.errors import PlantFault
from lockprobe.plants.catalogue import FilmHook
from lockprobe.plants.manual import Seen
from lockprobe.plants.operator import ConsentingOperator
from lockprobe.trial.record import Fact
from lockprobe_robot.arm.protocol import StoppableArm
from lockprobe_robot.box_model.panel import lay_out_panel
from lockprobe_robot.hardware.bounds import Bounded, Bounds
from lockprobe_robot.hardware.rig import Board, Rig
from lockprobe_robot.hardware.scripted_arm import ScriptedArm
from lockprobe_robot.plants import RehearsalRung

_BOUNDS = Bounds(low=(0.0, -0.6, 0.02), high=(0.85, 0.6, 0.9), answer=2.0)
"""The workspace of rehearsals. A busy machine may need two seconds for an answer; a robot may not."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _SimulatedSight:
    """Reads the truth from a simulation."""

    configuration: Callable[[], Configuration]
    facts: Mapping[str, Fact]
    close: Callable[[], None] = lambda: None

    def read(self, names: tuple[str, ...]) -> Seen:
        return Seen(configuration=self.configuration(), look=None)


def rehearsed_rig(
    rung: RehearsalRung,
    box: Lockbox,
    labels: tuple[str, ...],
    rng: np.random.Generator,
    film: FilmHook | None = None,
) -> Rig:
    """A rig on a rung, as a plant: ``--plant 'rig?rung=twin'``. No operator has to agree: nothing real moves."""
    arm: StoppableArm
    if rung == "scripted":
        panel = lay_out_panel(box)
        arm = scripted = ScriptedArm(box, panel.handle_path)
        sight = _SimulatedSight(configuration=lambda: scripted.configuration, facts={"truth": "simulation"})
    else:
        from lockprobe_robot.twin import Twin
        from lockprobe_robot.twin_settings import TwinSettings

        twin = Twin(box, labels=labels, settings=TwinSettings(), rng=rng, film=film)
        arm, panel = twin.arm, twin.panel

        def settled() -> Configuration:
            if not twin.settle():
                raise PlantFault("a joint stays between its ends")
            return twin.observe().configuration

        facts: dict[str, Fact] = {"truth": "simulation", "engine": twin.facts["engine"]}
        sight = _SimulatedSight(configuration=settled, facts=facts, close=twin.close)
    operator = ConsentingOperator()
    return Rig(
        box,
        labels=labels,
        arm=Bounded(arm, _BOUNDS, operator),
        board=Board(panel=panel),
        operator=operator,
        truth=sight,
        rung=rung,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class RehearsedAttempt:
    """One rehearsed attempt.

    Attributes:
        state: The configuration before, a bit string in panel order.
        joint: Name of the joint.
        free: Whether the rules let it move.
        verdict: The robot's verdict; empty if a fault ended the attempt.
        peak_force: Newtons; None if a fault ended the attempt.
        right: Whether the verdict and the configuration afterwards agree with the rules.
        fault: The fault that ended the attempt; empty without a fault.
    """

    state: str
    joint: str
    free: bool
    verdict: str = ""
    peak_force: float | None = None
    right: bool = False
    fault: str = ""


def rehearse(
    rung: RehearsalRung,
    box: Lockbox,
    *,
    attempts: int,
    seed: int = 1,
    tell: Callable[[RehearsedAttempt], None] = lambda attempted: None,
) -> tuple[tuple[RehearsedAttempt, ...], Mapping[str, Fact]]:
    """Attempt random joints, from the initial configuration on, and compare every verdict with the rules.

    After a fault, whose hand may hold a handle, a new rig begins again.
    All rungs make the same attempts with one seed. ``tell`` is called after every attempt. Returned are the attempts,
    in order, and the facts of the last rig.
    """
    luck = np.random.default_rng(seed)
    made: list[RehearsedAttempt] = []
    while True:
        rig = rehearsed_rig(rung, box, box.names, luck.spawn(1)[0])
        try:
            before = rig.observe().configuration
            while len(made) < attempts:
                joint = int(luck.integers(len(box.joints)))
                after, free = box.attempt(before, joint)
                state, name = bits(before), box.names[joint]
                try:
                    snapshot = rig.attempt(joint)
                except PlantFault as fault:
                    made.append(RehearsedAttempt(state=state, joint=name, free=free, fault=str(fault)))
                    tell(made[-1])
                    break
                verdict, force = str(snapshot.sensed["verdict"]), snapshot.sensed["peak_force"]
                right = snapshot.configuration == after and verdict == ("moved" if free else "blocked")
                made.append(
                    RehearsedAttempt(
                        state=state, joint=name, free=free, verdict=verdict, peak_force=float(force or 0), right=right
                    )
                )
                tell(made[-1])
                before = snapshot.configuration
            else:
                return tuple(made), rig.facts
        finally:
            rig.close()
