"""A plant's RGB-D camera: pictures of a MuJoCo model, true or as it is told falsely, rendered only on request."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict
from functools import partial
from typing import Protocol

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.box import Configuration
from lockprobe.foundation.errors import PlantFault
from lockprobe.trial.pictures.frame import Camera, Frame
from lockprobe.trial.record import Fact
from lockprobe_robot.box_model.scene import EYE
from lockprobe_robot.rendering.opengl import OpenGL, draw_view_error, shown_state
from lockprobe_robot.rendering.probe import open_renderer
from lockprobe_robot.twin_settings import CameraSettings

_FROM_OPENGL = np.diag([1.0, -1.0, -1.0])
"""MuJoCo's cameras look along -z with y up; cameras of pictures look along z with y down."""

_REFERENCE = 0.7
"""Depth in metres at which the noise has the stated size. Noise grows with depth squared, as in stereo cameras."""

_STEP = 0.02
"""Metres. Neighbouring pixels that differ by more form an edge."""

_LOST = 0.6
"""Share of pixels at edges that have no reading."""


class _PosableJoints(Protocol):
    def posed(self, configuration: Configuration) -> mujoco.MjData: ...


class _PanelGeometry(Protocol):
    @property
    def pose(self) -> NDArray[np.float64]: ...

    @property
    def handles(self) -> NDArray[np.float64]: ...


class PlantCamera:
    """A plant's camera for the present moment. Every attempt ends a moment.

    The renderer opens at the first look, so a plant without looks needs no OpenGL. Threads may take turns with it, one
    at a time. A process that is forked after the first look cannot look, because the graphics library's threads do not
    survive a fork and every call would hang. Start workers with ``spawn``, or fork before the first look.

    Args:
        model: The compiled scene.
        data: Its state; a look does not change it.
        mechanism: Its joints; ``posed`` gives a copy of the state with the joints in another configuration.
        panel: Pose of the panel in the world, shape (4, 4), and the handles' positions in its frame, shape
            (joints, 2, 3), metres.
        settings: Size of pictures, noise of depth.
        rng: A separate random stream. Each look draws one number of it for the noise of depth, and six of a child of it
            for the error of the view.
        eye: Name of the camera in the model.
        jitter: Standard deviation of the camera's shift along each axis, millimetres. Frames keep the nominal camera.
        turn: Standard deviation of its rotation about each axis, degrees.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        *,
        mechanism: _PosableJoints,
        panel: _PanelGeometry,
        settings: CameraSettings,
        rng: np.random.Generator,
        eye: str = EYE,
        jitter: float = 0.0,
        turn: float = 0.0,
    ) -> None:
        self._model, self._data, self._mechanism, self._panel = model, data, mechanism, panel
        self._settings, self._rng, self._eye = settings, rng, eye
        self._view, self._jitter, self._turn = rng.spawn(1)[0], jitter / 1000, math.radians(turn)
        self._seen = mujoco.MjData(model)
        self._moment = 0
        self._renderer: OpenGL | None = None
        self._drawn_by: str | None = None

    @property
    def facts(self) -> Mapping[str, Fact]:
        """Engine, settings and the renderer of the last picture (None if there was none), for the record."""
        return {"engine": f"mujoco {mujoco.__version__}", **asdict(self._settings), "renderer": self._drawn_by}

    def look_now(self) -> Callable[[], Frame]:
        """A function that takes a picture of this moment.

        It raises ``PlantFault`` once the moment is over, and ``Missing`` if the renderer does not work here.
        """
        return partial(self._look, self._moment, None)

    def look_as_told(self) -> Callable[[Configuration], Frame]:
        """As :meth:`look_now`, but the function draws the joints in a given configuration, for false pictures."""
        return partial(self._look, self._moment)

    def end_moment(self) -> None:
        """End the present moment and begin the next one."""
        self._moment += 1

    def close(self) -> None:
        """Release the renderer. The next look opens it again."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None

    def _look(self, moment: int, configuration: Configuration | None) -> Frame:
        if self._moment != moment:
            raise PlantFault("a picture was asked for after the next attempt")
        data, settings = self._data, self._settings
        if configuration is not None:
            data = self._mechanism.posed(configuration)
        if self._renderer is None:
            self._renderer = open_renderer(self._model, width=settings.width, height=settings.height)
        error = draw_view_error(self._jitter, self._turn, self._view)
        rgb, depth = self._renderer.render(data, self._eye, error)
        shown_state(self._model, data, self._seen)
        self._drawn_by = self._renderer.name
        return Frame(
            rgb=rgb,
            depth=add_depth_noise(depth, settings.depth_noise, self._rng),
            camera=self._geometry(),
            handles=self._panel.handles,
            renderer=self._renderer.name,
            labelled=getattr(settings, "labels", True),
        )

    def _geometry(self) -> Camera:
        """The nominal camera model: focal length, and the panel's pose in the camera's frame."""
        seen = self._model.camera(self._eye).id
        height, pose = self._settings.height, self._panel.pose
        rotation = self._seen.cam_xmat[seen].reshape(3, 3) @ _FROM_OPENGL
        panel = np.eye(4)
        panel[:3, :3] = rotation.T @ pose[:3, :3]
        panel[:3, 3] = rotation.T @ (pose[:3, 3] - self._seen.cam_xpos[seen])
        focal = 0.5 * height / math.tan(0.5 * math.radians(float(self._model.cam_fovy[seen])))
        return Camera(width=self._settings.width, height=height, focal=focal, panel=panel)


def add_depth_noise(depth: NDArray[np.float32], noise: float, rng: np.random.Generator) -> NDArray[np.float32]:
    """Simulate the errors of a depth camera: quantised to millimetres, noisy, with holes along edges.

    With ``noise=0`` it only rounds. It always draws one number from ``rng``, so the same stream gives the same errors
    at every noise level, scaled.

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
    """Pixels on both sides of a depth discontinuity."""
    edges = np.zeros(depth.shape, dtype=bool)
    across = np.abs(np.diff(depth, axis=1)) > _STEP
    edges[:, :-1] |= across
    edges[:, 1:] |= across
    down = np.abs(np.diff(depth, axis=0)) > _STEP
    edges[:-1] |= down
    edges[1:] |= down
    return edges
