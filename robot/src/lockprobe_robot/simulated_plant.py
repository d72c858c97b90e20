"""A simulation as a plant with an RGB-D camera: pictures, true or as it is told falsely, rendered only on request."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, replace
from functools import partial

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.box import Configuration
from lockprobe.foundation.errors import PlantFault
from lockprobe.trial.pictures.frame import Camera, Frame
from lockprobe.trial.record import Fact, Snapshot
from lockprobe_robot.box_model.joints import Joints
from lockprobe_robot.geom_groups import CAMERA
from lockprobe_robot.renderer import Renderer
from lockprobe_robot.twin_settings import CameraSettings

_FROM_OPENGL = np.diag([1.0, -1.0, -1.0])
"""MuJoCo's cameras look along -z with y up; cameras of pictures look along z with y down."""

_REFERENCE = 0.7
"""Depth in metres at which the noise has the stated size. Noise grows with depth squared, as in stereo cameras."""

_STEP = 0.02
"""Metres. Neighbouring pixels that differ by more form an edge."""

_LOST = 0.6
"""Share of pixels at edges that have no reading."""


class SimulatedPlant:
    """A simulation as a plant (base class).

    The renderer opens at the first look, so a plant without looks needs no OpenGL. A look raises ``PlantFault`` after
    the next attempt, and ``Missing`` if the renderer does not work here.

    Args:
        joints: The joints, in the model and the state that are looked at; a look does not change it.
        pose: Pose of the panel in the world, shape (4, 4).
        handles: The handles' positions at 0 and at 1 in its frame, shape (joints, 2, 3), metres.
        settings: Size of pictures, noise of depth, error of the view.
        rng: A separate random stream. Each look draws one number of it for the noise of depth, and three of a child of
            it for the error of the view.
    """

    def __init__(
        self,
        joints: Joints,
        *,
        pose: NDArray[np.float64],
        handles: NDArray[np.float64],
        settings: CameraSettings,
        rng: np.random.Generator,
    ) -> None:
        self.joints, self._pose, self._handles, self._settings = joints, pose, handles, settings
        self._noise, self._view = rng, rng.spawn(1)[0]
        self._attempts = 0
        self._renderer: Renderer | None = None
        self._drawn_by: str | None = None

    @property
    def facts(self) -> Mapping[str, Fact]:
        """Engine, settings and the renderer of the last picture (None if there was none), for the record."""
        return {"engine": f"mujoco {mujoco.__version__}", **asdict(self._settings), "renderer": self._drawn_by}

    def observe(self) -> Snapshot:
        """The truth now."""
        render = partial(self._look, self._attempts)
        return Snapshot(configuration=self.joints.configuration(), look=partial(render, None), render=render)

    def attempt(self, joint: int) -> Snapshot:
        """Attempt a joint, by index in panel order.

        Raises:
            PlantFault: If a joint stays between its ends, another joint moves, an arm is blocked, or the simulation
                becomes unstable.
        """
        before = self.joints.configuration()
        self._attempts += 1
        sensed = self._act(joint, before)
        after = self.joints.configuration_after(joint, before)
        return replace(
            self.observe(), joint=joint, outcome="moved" if after[joint] != before[joint] else "blocked", sensed=sensed
        )

    def _act(self, joint: int, before: Configuration) -> Mapping[str, Fact]:
        """Act on a joint until the box is at rest, by a push if no arm does; what a robot sensed."""
        self.joints.push(joint)
        return {}

    def close(self) -> None:
        """Release the renderer. The next look opens it again."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None

    def _look(self, attempts: int, configuration: Configuration | None) -> Frame:
        """A picture of a moment, or of the joints as they are told falsely."""
        if self._attempts != attempts:
            raise PlantFault("a picture was asked for after the next attempt")
        settings, model = self._settings, self.joints.model
        if self._renderer is None:
            self._renderer = Renderer(model, width=settings.width, height=settings.height)
        renderer, eye = self._renderer, model.camera(CAMERA).id
        seen = renderer.pose(self.joints.data if configuration is None else self.joints.posed(configuration))
        rotation = seen.cam_xmat[eye].reshape(3, 3) @ _FROM_OPENGL
        panel = np.eye(4)
        panel[:3, :3] = rotation.T @ self._pose[:3, :3]
        panel[:3, 3] = rotation.T @ (self._pose[:3, 3] - seen.cam_xpos[eye])
        focal = 0.5 * settings.height / math.tan(0.5 * math.radians(float(model.cam_fovy[eye])))
        camera = Camera(width=settings.width, height=settings.height, focal=focal, panel=panel)
        # As much is drawn whatever the size is, so a larger error is the same luck enlarged.
        shift = settings.view_jitter / 1000 * self._view.standard_normal(3)
        seen.cam_xpos[eye] += seen.cam_xmat[eye].reshape(3, 3) @ shift
        rgb, depth = renderer.colours(CAMERA), renderer.depth(CAMERA)
        self._drawn_by = renderer.name
        return Frame(
            rgb=rgb,
            depth=add_depth_noise(depth, settings.depth_noise, self._noise),
            camera=camera,
            handles=self._handles,
            renderer=renderer.name,
            labelled=settings.labels,
        )


def add_depth_noise(depth: NDArray[np.float32], noise: float, rng: np.random.Generator) -> NDArray[np.float32]:
    """Simulate the errors of a depth camera: quantised to millimetres, noisy, with holes along edges.

    With ``noise=0`` it only rounds. It always draws one number from ``rng``, so the same stream gives the same errors
    at every noise level, scaled.
    Depth has the shape (height, width), metres; 0 is no reading. ``noise`` is the standard deviation at 0.7 m, metres.
    """
    luck = np.random.Generator(np.random.PCG64(int(rng.integers(2**63))))
    read = depth
    if noise > 0:
        errors = luck.standard_normal(depth.shape, dtype=np.float32)
        lost = luck.random(depth.shape, dtype=np.float32) < _LOST
        edges = np.zeros(depth.shape, dtype=bool)  # pixels on both sides of a discontinuity
        across = np.abs(np.diff(depth, axis=1)) > _STEP
        edges[:, :-1] |= across
        edges[:, 1:] |= across
        down = np.abs(np.diff(depth, axis=0)) > _STEP
        edges[:-1] |= down
        edges[1:] |= down
        read = depth + np.float32(noise) * (depth / np.float32(_REFERENCE)) ** 2 * errors
        read = np.where((depth > 0) & ~(lost & edges), read, np.float32(0))
    rounded: NDArray[np.float32] = np.rint(read * np.float32(1000)) / np.float32(1000)
    return rounded
