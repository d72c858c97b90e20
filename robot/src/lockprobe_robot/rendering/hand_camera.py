"""A free camera in a lockbox's scene, like one on a robot's hand: pictures for rehearsals of a calibration."""

from __future__ import annotations

import math

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe_robot.rendering.choose_renderer import open_renderer
from lockprobe_robot.twin_settings import RendererChoice

__all__ = ["HandCamera"]

_CAMERA = "hand-camera"
_FROM_OPENGL = np.diag([1.0, -1.0, -1.0])
"""MuJoCo's cameras look along -z with y up; cameras of pictures look along z with y down."""


class HandCamera:
    """A camera that can be placed at any pose in a scene.

    Args:
        spec: The scene before it is compiled; it is changed.
        width: Pixels.
        height: Pixels.
        fovy: Vertical field of view, degrees.
        renderer: The renderer.
    """

    def __init__(
        self,
        spec: mujoco.MjSpec,
        *,
        width: int = 640,
        height: int = 480,
        fovy: float = 58.0,
        renderer: RendererChoice = "auto",
    ) -> None:
        carrier = spec.worldbody.add_body(name=_CAMERA, mocap=True)
        carrier.add_camera(name=_CAMERA, fovy=fovy)
        self._model = spec.compile()
        self._data = mujoco.MjData(self._model)
        self._renderer = open_renderer(self._model, width=width, height=height, choice=renderer)
        self.focal = 0.5 * height / math.tan(0.5 * math.radians(fovy))
        """Focal length, pixels; the optical axis is in the middle of the picture."""

    @property
    def name(self) -> str:
        """Name of the renderer, for the record."""
        return self._renderer.name

    def look(self, pose: NDArray[np.float64]) -> NDArray[np.uint8]:
        """A picture, shape (height, width, 3).

        Args:
            pose: Pose of the camera in the world, shape (4, 4), metres: x to the right, y down, z away from it.
        """
        self._data.mocap_pos[0] = pose[:3, 3]
        mujoco.mju_mat2Quat(self._data.mocap_quat[0], np.ascontiguousarray(pose[:3, :3] @ _FROM_OPENGL).ravel())
        rgb, _ = self._renderer.render(self._data, _CAMERA)
        return rgb

    def close(self) -> None:
        """Release the renderer."""
        self._renderer.close()
