"""The rungs of a rehearsal: builds the arm, the box and the source of the truth of each."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from lockprobe.boxes.box import Configuration, Lockbox
from lockprobe.foundation.errors import BadValue
from lockprobe.plants.catalogue import FilmHook
from lockprobe.trial.record import Fact
from lockprobe_robot.arm.guarded_move import HandlePath
from lockprobe_robot.arm.protocol import StoppableArm
from lockprobe_robot.box_model.panel import lay_out_panel
from lockprobe_robot.handle_path import handle_path
from lockprobe_robot.hardware.scripted_arm import ScriptedArm
from lockprobe_robot.rehearsal_settings import RehearsalRung
from lockprobe_robot.simulation import require_mujoco

if TYPE_CHECKING:
    from lockprobe.trial.pictures.frame import Frame

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
        look: Takes a picture of the box; None if the rung has none.
    """

    arm: StoppableArm
    path: Callable[[int, bool], HandlePath]
    state: Callable[[], Configuration]
    put: Callable[[Configuration], None]
    close: Callable[[], None] = lambda: None
    facts: Mapping[str, Fact] = field(default_factory=dict)
    look: Callable[[], Frame] | None = None


def parts_of(
    rung: str, box: Lockbox, labels: tuple[str, ...], rng: np.random.Generator, film: FilmHook | None = None
) -> Parts:
    """The parts of a rung, with the box in its initial configuration; ``scripted`` cannot be filmed.

    Raises:
        BadValue: If there is no such rung.
        Missing: If a package is missing.
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
        return _twin(box, labels, rng, film)
    raise BadValue("rung", rung, f"one of {', '.join(RUNGS)}")


def _twin(box: Lockbox, labels: tuple[str, ...], rng: np.random.Generator, film: FilmHook | None) -> Parts:
    require_mujoco()
    from lockprobe_robot.twin import Twin
    from lockprobe_robot.twin_settings import TwinSettings

    twin = Twin(box, labels=labels, settings=TwinSettings(), rng=rng, film=film)

    def look() -> Frame:
        seen = twin.observe().look
        assert seen is not None
        return seen()

    return Parts(
        arm=twin.arm,
        path=partial(handle_path, twin.panel),
        state=twin.settled,
        put=twin.put,
        close=twin.close,
        facts={"engine": twin.facts["engine"]},
        look=look,
    )
