"""A plant's depth camera: pictures of a MuJoCo model, rendered only when somebody looks."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict
from functools import partial

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe.errors import BadValue, PlantFault
from lockprobe.lockbox.box import Configuration
from lockprobe.pictures.frame import Camera, Frame
from lockprobe.plants.rendering.choose_renderer import open_renderer
from lockprobe.plants.rendering.renderer import Renderer, shown_state
from lockprobe.plants.scene.mechanism import Mechanism
from lockprobe.plants.scene.scene import LockboxScene
from lockprobe.plants.twin_settings import SceneSettings
from lockprobe.record import Fact

__all__ = ["FixedCamera", "PlantCamera", "add_depth_noise"]

_FROM_OPENGL = np.diag([1.0, -1.0, -1.0])
"""MuJoCo's cameras look along -z with y up; cameras of pictures look along z with y down."""

_REFERENCE = 0.7
"""Depth in metres at which the noise has the stated size. Noise grows with depth squared, as in stereo cameras."""

_STEP = 0.02
"""Metres. Neighbouring pixels that differ by more form an edge."""

_LOST = 0.6
"""Share of pixels at edges that have no reading."""


class PlantCamera:
    """A plant's camera, which takes pictures of the present moment. Every attempt ends a moment.

    Args:
        model: The compiled scene, with whatever was added to it.
        data: Its state; the camera reads it and never changes it.
        mechanism: Its joints.
        scene: Where the panel is, and which camera looks at it.
        settings: Of the plant.
        rng: The camera's random stream, for the noise of depth.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        *,
        mechanism: Mechanism,
        scene: LockboxScene,
        settings: SceneSettings,
        rng: np.random.Generator,
    ) -> None:
        self._data, self._panel, self._settings, self._rng = data, scene.panel, settings, rng
        self._mechanism = mechanism
        self._camera = FixedCamera(model, scene.camera, settings)
        self._moment = 0
        self._renderer: str | None = None

    @property
    def facts(self) -> Mapping[str, Fact]:
        """Engine, settings and the renderer of the last picture (None if there was none), for the record."""
        return {"engine": f"mujoco {mujoco.__version__}", **asdict(self._settings), "renderer": self._renderer}

    def look_now(self) -> Callable[[], Frame]:
        """A function that takes a picture of this moment; it raises PlantFault once the moment is over."""
        return partial(self._look, self._moment, None)

    def look_as_if(self) -> Callable[[Configuration], Frame]:
        """As :meth:`look_now`, but the function draws the joints in the configuration that it is given."""
        return partial(self._look, self._moment)

    def _look(self, moment: int, configuration: Configuration | None) -> Frame:
        if self._moment != moment:
            raise PlantFault("a picture was asked for after the next attempt")
        data = self._data if configuration is None else self._mechanism.posed(configuration)
        frame = self._camera.look(data, self._panel.pose, self._panel.handles, self._rng)
        self._renderer = frame.renderer
        return frame

    def end_moment(self) -> None:
        """End the present moment and begin the next one."""
        self._moment += 1

    def close(self) -> None:
        """Release the renderer."""
        self._camera.close()


class FixedCamera:
    """A camera of a model. It opens its renderer at the first look, so a plant that nobody looks at needs no OpenGL.

    Threads may take turns with it, one at a time. A process that is forked after the first look cannot look, because
    the graphics library's threads do not survive a fork and every call would hang. Start workers with ``spawn``, or
    fork before the first look.

    Args:
        model: The compiled model.
        camera: Name of a camera in it.
        settings: Size of pictures, renderer, noise of depth.

    Raises:
        BadValue: If the model has no such camera.
    """

    def __init__(self, model: mujoco.MjModel, camera: str, settings: SceneSettings) -> None:
        self._model = model
        self._seen = mujoco.MjData(model)
        self._camera = camera
        self._settings = settings
        self._renderer: Renderer | None = None
        if mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_CAMERA, camera) < 0:
            raise BadValue("camera", camera, f"one of {', '.join(model.camera(i).name for i in range(model.ncam))}")

    def look(
        self,
        data: mujoco.MjData,
        panel_pose: NDArray[np.float64],
        handles: NDArray[np.float64],
        rng: np.random.Generator,
    ) -> Frame:
        """Take a picture. The state of the simulation is read and not changed.

        Args:
            data: The state to draw.
            panel_pose: Pose of the panel in the world, shape (4, 4), metres.
            handles: Copied into the frame.
            rng: For the noise of depth. A look draws one number whatever the noise is. Give the camera a separate
                stream, so that looking changes no luck elsewhere.

        Raises:
            Missing: If the renderer asked for does not work here.
        """
        if self._renderer is None:
            settings = self._settings
            self._renderer = open_renderer(
                self._model, width=settings.width, height=settings.height, choice=settings.renderer
            )
        rgb, depth = self._renderer.render(data, self._camera)
        shown_state(self._model, data, self._seen)
        return Frame(
            rgb=rgb,
            depth=add_depth_noise(depth, self._settings.depth_noise, rng),
            camera=self._geometry(panel_pose),
            handles=handles,
            renderer=self._renderer.name,
        )

    def close(self) -> None:
        """Release the renderer. The next look opens it again."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None

    def _geometry(self, panel_pose: NDArray[np.float64]) -> Camera:
        """Focal length of the camera and the panel's pose in its frame."""
        seen = self._model.camera(self._camera).id
        height = self._settings.height
        rotation = self._seen.cam_xmat[seen].reshape(3, 3) @ _FROM_OPENGL
        panel = np.eye(4)
        panel[:3, :3] = rotation.T @ panel_pose[:3, :3]
        panel[:3, 3] = rotation.T @ (panel_pose[:3, 3] - self._seen.cam_xpos[seen])
        focal = 0.5 * height / math.tan(0.5 * math.radians(float(self._model.cam_fovy[seen])))
        return Camera(width=self._settings.width, height=height, focal=focal, panel=panel)


def add_depth_noise(depth: NDArray[np.float32], noise: float, rng: np.random.Generator) -> NDArray[np.float32]:
    """Depth as a depth camera reads it: in whole millimetres, noisy, with holes along edges.

    With ``noise=0`` it only rounds. It draws one number from ``rng`` whatever the noise is. The same stream gives the
    same errors at every noise level, scaled.

    Args:
        depth: Shape (height, width), metres; 0 where there is nothing.
        noise: Standard deviation at 0.7 m, metres.
        rng: Random stream.

    Returns:
        The same shape; 0 where there is no reading.
    """
    luck = np.random.Generator(np.random.PCG64(int(rng.integers(2**63))))
    read = depth
    if noise > 0:
        errors = luck.standard_normal(depth.shape, dtype=np.float32)
        lost = luck.random(depth.shape, dtype=np.float32) < _LOST
        read = depth + np.float32(noise) * (depth / np.float32(_REFERENCE)) ** 2 * errors
        read = np.where((depth > 0) & ~(lost & _edges(depth)), read, np.float32(0))
    rounded: NDArray[np.float32] = np.rint(read * np.float32(1000)) / np.float32(1000)
    return rounded


def _edges(depth: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Pixels on both sides of a step in depth."""
    edges = np.zeros(depth.shape, dtype=bool)
    across = np.abs(np.diff(depth, axis=1)) > _STEP
    edges[:, :-1] |= across
    edges[:, 1:] |= across
    down = np.abs(np.diff(depth, axis=0)) > _STEP
    edges[:-1] |= down
    edges[1:] |= down
    return edges
