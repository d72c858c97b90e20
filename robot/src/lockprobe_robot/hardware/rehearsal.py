"""The plant ``rig``: all software of a rig without the robot.

The twin's arm is driven by the same :class:`~lockprobe_robot.hardware.rig.Rig`, bounds and guarded move as a real one;
the simulation tells the truth.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from lockprobe.boxes.box import Lockbox
from lockprobe.foundation.errors import PlantFault
from lockprobe.plants.catalogue import FilmHook
from lockprobe.plants.manual import ENTER, OperatorStopped
from lockprobe.trial.record import Fact, Snapshot
from lockprobe_robot.hardware.bounds import Bounded, Bounds
from lockprobe_robot.hardware.rig import Rig
from lockprobe_robot.twin import Twin
from lockprobe_robot.twin_settings import TwinSettings

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


class _TwinSight:
    """Reads the truth from a simulation."""

    def __init__(self, twin: Twin) -> None:
        self._twin, self.close = twin, twin.close
        self.facts: Mapping[str, Fact] = {"truth": "simulation", "engine": twin.facts["engine"]}

    def read(self, names: tuple[str, ...]) -> Snapshot:
        if not self._twin.settle():
            raise PlantFault("a joint stays between its ends")
        return Snapshot(configuration=self._twin.joints.configuration())


def rehearsed_rig(box: Lockbox, labels: tuple[str, ...], rng: np.random.Generator, film: FilmHook | None = None) -> Rig:
    """A rig of the twin's parts, as a plant. No operator has to agree: nothing real moves."""
    twin, operator = Twin(box, labels=labels, settings=TwinSettings(), rng=rng, film=film), ConsentingOperator()
    return Rig(
        box,
        labels=labels,
        arm=Bounded(twin.arm, _BOUNDS, operator),
        panel=twin.panel,
        operator=operator,
        truth=_TwinSight(twin),
        rung="twin",
    )
