"""The plant ``rig``: all software of a rig without the robot, on two rungs of increasing realism.

* ``scripted``: an arm without a body; the whole program runs in milliseconds.
* ``twin``: the simulated arm and box in this process.

Both drive the same :class:`~lockprobe_robot.hardware.rig.Rig`, bounds and guarded move; the simulation tells the truth.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from lockprobe.boxes.box import Configuration, Lockbox
from lockprobe.foundation.errors import PlantFault
from lockprobe.plants.catalogue import FilmHook
from lockprobe.plants.manual import ENTER, OperatorStopped
from lockprobe.trial.record import Fact, Snapshot
from lockprobe_robot.arm.protocol import StoppableArm
from lockprobe_robot.box_model.panel import lay_out_panel
from lockprobe_robot.hardware.bounds import Bounded, Bounds
from lockprobe_robot.hardware.rig import Rig
from lockprobe_robot.hardware.scripted_arm import ScriptedArm

_BOUNDS = Bounds(low=(0.0, -0.6, 0.02), high=(0.85, 0.6, 0.9), answer=2.0)
"""The workspace of rehearsals. A busy machine may need two seconds for an answer; a robot may not."""


class ConsentingOperator:
    """An automatic operator that agrees to everything, only for rehearsals in which nothing real moves."""

    def __init__(self) -> None:
        self._began = False

    def ask(self, question: str, answers: Sequence[str]) -> str:
        """Yes, or Enter once."""
        if ENTER not in answers:
            return "y"
        if self._began:
            raise OperatorStopped("the box does not stand as it should, and nobody is there to set it up")
        self._began = True
        return ENTER

    def tell(self, line: str) -> None:
        """Discard the line."""


@dataclass(frozen=True, slots=True)
class _SimulatedSight:
    """Reads the truth from a simulation."""

    configuration: Callable[[], Configuration]
    close: Callable[[], None]
    facts: Mapping[str, Fact]

    def read(self, names: tuple[str, ...]) -> Snapshot:
        return Snapshot(configuration=self.configuration())


def rehearsed_rig(
    rung: str, box: Lockbox, labels: tuple[str, ...], rng: np.random.Generator, film: FilmHook | None = None
) -> Rig:
    """A rig on a rung, as a plant: ``--plant 'rig?rung=twin'``. No operator has to agree: nothing real moves."""
    arm: StoppableArm
    if rung == "scripted":
        panel = lay_out_panel(box)
        arm = scripted = ScriptedArm(box, panel.handle_path)
        sight = _SimulatedSight(lambda: scripted.configuration, lambda: None, {"truth": "simulation"})
    else:
        from lockprobe_robot.twin import Twin
        from lockprobe_robot.twin_settings import TwinSettings

        twin = Twin(box, labels=labels, settings=TwinSettings(), rng=rng, film=film)
        arm, panel = twin.arm, twin.panel

        def settled() -> Configuration:
            if not twin.settle():
                raise PlantFault("a joint stays between its ends")
            return twin.joints.configuration()

        sight = _SimulatedSight(settled, twin.close, {"truth": "simulation", "engine": twin.facts["engine"]})
    operator = ConsentingOperator()
    return Rig(
        box,
        labels=labels,
        arm=Bounded(arm, _BOUNDS, operator),
        panel=panel,
        operator=operator,
        truth=sight,
        rung=rung,
    )
