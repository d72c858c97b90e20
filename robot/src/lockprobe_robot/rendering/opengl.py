"""The off-screen OpenGL renderer, through EGL (CGL on macOS).

MuJoCo picks its OpenGL platform from the environment variable MUJOCO_GL when it is imported, and the import fails where
that platform's library is missing. So this module leaves the variable alone and creates the context explicitly.
"""

from __future__ import annotations

import copy
import importlib
import importlib.metadata
import os
import sys
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue
from lockprobe_robot.geom_groups import SHOWN_GROUPS

_PLATFORM = "cgl" if sys.platform == "darwin" else "egl"

_SHADOW_PIXELS = 2048
_SAMPLES = 4
"""Samples per pixel of colour pictures (anti-aliasing). Depth is never averaged over an edge."""

_PLATFORM_VARIABLE = "PYOPENGL_PLATFORM"

_opened: list[int] = []
"""The process of the first context. A fork of it can have none."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ViewError:
    """How far a camera is from where it should be.

    Attributes:
        shift: Along the camera's own axes, shape (3,), metres.
        turn: Rotation vector about these axes, shape (3,), radians.
    """

    shift: NDArray[np.float64]
    turn: NDArray[np.float64]

    def move(self, seen: mujoco.MjData, eye: int) -> None:
        """Move a camera of a state whose poses are computed, by index."""
        axes = seen.cam_xmat[eye].reshape(3, 3).copy()
        quaternion, rotation = np.zeros(4), np.zeros(9)
        angle = float(np.linalg.norm(self.turn))
        mujoco.mju_axisAngle2Quat(quaternion, self.turn / max(angle, 1e-12), angle)
        mujoco.mju_quat2Mat(rotation, quaternion)
        seen.cam_xpos[eye] += axes @ self.shift
        seen.cam_xmat[eye] = (axes @ rotation.reshape(3, 3)).ravel()


def draw_view_error(shift: float, turn: float, rng: np.random.Generator) -> ViewError | None:
    """The error of one picture: the same luck, scaled. Six numbers are drawn, whatever the sizes are.

    Args:
        shift: Standard deviation along each axis, metres.
        turn: Standard deviation about each axis, radians.
        rng: Random stream.

    Returns:
        None where both are 0.
    """
    luck = rng.standard_normal(6)
    return ViewError(shift=shift * luck[:3], turn=turn * luck[3:]) if shift or turn else None


class OpenGL:
    """A renderer that draws with OpenGL. Threads may take turns with it, one at a time.

    Args:
        model: What to draw.
        width: Pixels.
        height: Pixels.

    Raises:
        BadValue: If this process was forked from one that has opened a renderer.
        ImportError, AttributeError, RuntimeError: As MuJoCo and PyOpenGL raise them where the platform is missing or
            broken;
            :mod:`lockprobe_robot.rendering.probe` checks that beforehand.
    """

    def __init__(self, model: mujoco.MjModel, *, width: int, height: int) -> None:
        self._model = copy.copy(model)
        self._model.vis.quality.offsamples = _SAMPLES
        self._model.vis.quality.shadowsize = _SHADOW_PIXELS
        self._model.vis.global_.offwidth = width
        self._model.vis.global_.offheight = height
        self._seen = mujoco.MjData(self._model)
        self._scene = mujoco.MjvScene(self._model, 2 * model.ngeom + 100)
        self._options = shown_options()
        self._window = mujoco.MjrRect(0, 0, width, height)
        self._context = _open_context(width, height)
        # The context is current only while it is used, so that another thread can use it next.
        with self._context.as_current():
            self._drawing = mujoco.MjrContext(self._model, mujoco.mjtFontScale.mjFONTSCALE_100)
            mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._drawing)
            driver = _driver()
        # Depth 1 at the near plane and 0 at the far one: floats are densest where things are far.
        self._drawing.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
        self.name = f"{_PLATFORM} (mujoco {importlib.metadata.version('mujoco')}, {driver})"

    def render(
        self, data: mujoco.MjData, camera: str, error: ViewError | None = None
    ) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """Draw what a camera sees. The state is read and not changed.

        Args:
            data: State of the model.
            camera: Name of a camera of the model.
            error: How far the camera is from its place in the model.

        Returns:
            Colours, shape (height, width, 3); depth along the optical axis in metres, shape (height, width), 0 where
            there is nothing.
        """
        with self._context.as_current():
            self._look(data, camera, error)
            rgb, buffer = self._colours(), np.empty((self._window.height, self._window.width), np.float32)
            flags = self._scene.flags.copy()
            # Flat colours are drawn without lights, shadows and several samples a pixel.
            self._scene.flags[mujoco.mjtRndFlag.mjRND_SEGMENT] = True
            self._scene.flags[mujoco.mjtRndFlag.mjRND_IDCOLOR] = True
            mujoco.mjr_render(self._window, self._scene, self._drawing)
            mujoco.mjr_readPixels(None, buffer, self._window, self._drawing)
            self._scene.flags[:] = flags
        return rgb, self._metres(buffer[::-1])

    def colours(self, data: mujoco.MjData, camera: str) -> NDArray[np.uint8]:
        """The colours alone of what a camera sees, as :meth:`render` draws them."""
        with self._context.as_current():
            self._look(data, camera, None)
            return self._colours()

    def close(self) -> None:
        """Free the context."""
        with self._context.as_current():
            self._drawing.free()
        self._context.free()

    def _look(self, data: mujoco.MjData, camera: str, error: ViewError | None) -> None:
        shown_state(self._model, data, self._seen)
        eye = mujoco.MjvCamera()
        eye.type = mujoco.mjtCamera.mjCAMERA_FIXED
        eye.fixedcamid = self._model.camera(camera).id
        if error is not None:
            error.move(self._seen, eye.fixedcamid)
        bodies = mujoco.mjtCatBit.mjCAT_STATIC | mujoco.mjtCatBit.mjCAT_DYNAMIC
        mujoco.mjv_updateScene(self._model, self._seen, self._options, None, eye, bodies, self._scene)

    def _colours(self) -> NDArray[np.uint8]:
        rgb = np.empty((self._window.height, self._window.width, 3), np.uint8)
        mujoco.mjr_render(self._window, self._scene, self._drawing)
        mujoco.mjr_readPixels(rgb, None, self._window, self._drawing)
        return rgb[::-1].copy()

    def _metres(self, buffer: NDArray[np.float32]) -> NDArray[np.float32]:
        """Linearise the depth buffer, which holds (near / z - near / far) / (1 - near / far)."""
        extent = self._model.stat.extent
        near = self._model.vis.map.znear * extent
        far = self._model.vis.map.zfar * extent
        depth = near / (buffer * np.float64(1 - near / far) + near / far)
        return np.where(buffer > 0, depth, 0).astype(np.float32)


def _open_context(width: int, height: int) -> Any:
    if _opened and _opened[0] != os.getpid():
        raise BadValue("renderer", _PLATFORM, "no OpenGL in a process forked after it was opened: use spawn")
    before = os.environ.get(_PLATFORM_VARIABLE)
    try:
        context = importlib.import_module(f"mujoco.{_PLATFORM}").GLContext(width, height)
    finally:
        if before is None:
            # The import set it for PyOpenGL, which has read it by now; child processes must not inherit it.
            os.environ.pop(_PLATFORM_VARIABLE, None)
    _opened.append(os.getpid())
    return context


def _driver() -> str:
    gl = importlib.import_module("OpenGL.GL")
    return bytes(gl.glGetString(gl.GL_RENDERER)).decode()


def shown_options() -> mujoco.MjvOption:
    """Options under which only the shown geoms are drawn."""
    options = mujoco.MjvOption()
    options.geomgroup[:] = SHOWN_GROUPS
    options.sitegroup[:] = False
    options.flags[mujoco.mjtVisFlag.mjVIS_TENDON] = False
    return options


def shown_state(model: mujoco.MjModel, data: mujoco.MjData, seen: mujoco.MjData) -> None:
    """Copy the state ``data`` into ``seen`` and compute all poses there. ``data`` keeps every bit."""
    everything = mujoco.mjtState.mjSTATE_PHYSICS | mujoco.mjtState.mjSTATE_USER
    state = np.empty(mujoco.mj_stateSize(model, everything))
    mujoco.mj_getState(model, data, state, everything)
    mujoco.mj_setState(model, seen, state, everything)
    mujoco.mj_kinematics(model, seen)
    mujoco.mj_comPos(model, seen)
    mujoco.mj_camlight(model, seen)
