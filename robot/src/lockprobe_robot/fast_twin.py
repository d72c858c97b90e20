"""The plant ``fast-twin``: the simulated lockbox pushed by a force instead of an arm, with the same camera."""

from __future__ import annotations

import numpy as np

from lockprobe.boxes.box import Lockbox
from lockprobe_robot.box_model.mechanism import Mechanism
from lockprobe_robot.box_model.scene import build_scene
from lockprobe_robot.simulated_plant import SimulatedPlant
from lockprobe_robot.twin_settings import SceneSettings


class FastTwin(SimulatedPlant):
    """A simulated lockbox whose handles are pushed by a force, without an arm.

    The appearance draws from ``rng``, noise of depth and error of the view from a child of it. BadValue is raised if
    the box cannot be built.
    """

    def __init__(
        self, box: Lockbox, *, labels: tuple[str, ...], settings: SceneSettings, rng: np.random.Generator
    ) -> None:
        scene = build_scene(box, labels=labels, settings=settings, rng=rng)
        joints, panel = Mechanism(scene), scene.panel
        super().__init__(joints, pose=panel.pose, handles=panel.handles, settings=settings, rng=rng.spawn(1)[0])
        joints.set_configuration(box.initial)
        joints.settle()
