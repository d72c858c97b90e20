"""The camera of a plant: pictures of a MuJoCo model, taken when somebody looks."""

from __future__ import annotations

import math

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe.errors import BadValue
from lockprobe.pictures.frame import Camera, Frame
from lockprobe.plants.rendering.depth_sensor import sense_depth
from lockprobe.plants.rendering.renderers import Renderer, open_renderer
from lockprobe.plants.rendering.visible import shown_state
from lockprobe.plants.settings import SceneSettings

__all__ = ["Eye"]

_FROM_OPENGL = np.diag([1.0, -1.0, -1.0])
"""MuJoCo's cameras look along -z with y up; those of pictures look along z with y down."""


class Eye:
    """A fixed camera. The renderer is opened at the first look, so that what never looks never touches OpenGL.

    Threads may take turns with it, one at a time. A process that is forked after the first look cannot look: the
    graphics library's threads do not survive a fork and every call would hang, so that it is refused. Start workers
    with ``spawn``, or fork before.

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
            data: The state to be seen.
            panel_pose: Pose of the panel in the world, shape (4, 4), metres.
            handles: Passed on into the frame.
            rng: For the noise of depth. One number is drawn per look whatever the noise is. It should be a stream of
                the camera's own, so that one who does not look has the same luck elsewhere.

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
            depth=sense_depth(depth, self._settings.depth_noise, rng),
            camera=self._place(panel_pose),
            handles=handles,
            renderer=self._renderer.name,
        )

    def close(self) -> None:
        """Let go of the renderer. Looking again opens it anew."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None

    def _place(self, panel_pose: NDArray[np.float64]) -> Camera:
        seen = self._model.camera(self._camera).id
        height = self._settings.height
        rotation = self._seen.cam_xmat[seen].reshape(3, 3) @ _FROM_OPENGL
        panel = np.eye(4)
        panel[:3, :3] = rotation.T @ panel_pose[:3, :3]
        panel[:3, 3] = rotation.T @ (panel_pose[:3, 3] - self._seen.cam_xpos[seen])
        focal = 0.5 * height / math.tan(0.5 * math.radians(float(self._model.cam_fovy[seen])))
        return Camera(width=self._settings.width, height=height, focal=focal, panel=panel)
