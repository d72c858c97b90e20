"""The MuJoCo scene of rehearsals over the wire: the twin's box and arm, with built-in gravity compensation.

The process that simulates the robot steps one copy. A second copy with the same seed receives its poses, to take
pictures.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import mujoco
import numpy as np

from lockprobe.boxes.box import Lockbox
from lockprobe.trial.pictures.frame import Frame
from lockprobe_robot.arm.hand import add_hand
from lockprobe_robot.arm.panda import HOME, JOINTS, add_panda
from lockprobe_robot.arm.skin import wear_skin
from lockprobe_robot.rendering.plant_camera import PlantCamera
from lockprobe_robot.scene.mechanism import Mechanism
from lockprobe_robot.scene.scene import build_scene
from lockprobe_robot.twin_settings import TwinSettings

__all__ = ["WireScene"]

_STEP = 0.001
"""Seconds of one step: the robot's control rate."""


class WireScene:
    """The compiled scene with the box in its initial configuration and the arm at home.

    Args:
        box: The box.
        labels: Labels of its joints, in panel order.
        seed: Seed of its appearance.
        skin: Description of the arm's visible shape, which changes no physics; None for primitive shapes.
    """

    def __init__(self, box: Lockbox, labels: tuple[str, ...], seed: int, *, skin: Path | None = None) -> None:
        settings = TwinSettings()
        scene = build_scene(box, labels=labels, settings=settings, rng=np.random.default_rng(seed))
        add_hand(scene.spec, add_panda(scene.spec), stiffness=settings.finger_stiffness)
        if skin is not None:
            wear_skin(scene.spec, skin)
        # A Franka compensates gravity by itself: of its links, and of the tool that it is told of.
        for body in scene.spec.bodies:
            body.gravcomp = float(body.name.startswith(("link", "flange", "hand", "finger")))
        scene.spec.option.timestep = _STEP
        self.model = scene.spec.compile()
        self.data = mujoco.MjData(self.model)
        self.mechanism = Mechanism(self.model, self.data, scene)
        self.mechanism.set_configuration(box.initial)
        self.data.qpos[self.arm_addresses] = HOME
        mujoco.mj_forward(self.model, self.data)
        self._camera = partial(
            PlantCamera,
            self.model,
            self.data,
            mechanism=self.mechanism,
            panel=scene.panel,
            settings=settings,
            rng=np.random.default_rng(seed),
        )
        self._opened: PlantCamera | None = None

    @property
    def arm_addresses(self) -> list[int]:
        """Indices of the arm's joint angles in ``qpos``."""
        return [int(self.model.joint(f"arm-{number}").qposadr[0]) for number in range(1, JOINTS + 1)]

    def pose(self, positions: Sequence[float]) -> None:
        """Set ``qpos`` to that of another copy."""
        self.data.qpos[:] = positions
        mujoco.mj_kinematics(self.model, self.data)

    def look(self) -> Frame:
        """A picture of the present state, by the twin's camera."""
        self._opened = self._opened or self._camera()
        return self._opened.look_now()()

    def close(self) -> None:
        """Release the renderer."""
        if self._opened is not None:
            self._opened.close()
