"""The off-screen OpenGL renderer: EGL or OSMesa.

MuJoCo picks its OpenGL platform from the environment variable MUJOCO_GL when it is imported, and the import fails where
that platform's library is missing. So this module leaves the variable alone and creates the context explicitly.
"""

from __future__ import annotations

import copy
import importlib
import os
from typing import Any, Literal

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue
from lockprobe_robot.rendering.renderer import shown_options, shown_state, title
from lockprobe_robot.rendering.view_error import ViewError

__all__ = ["OpenGL"]

_SHADOW_PIXELS = 2048
_SAMPLES = 4
"""Samples per pixel of colour pictures (anti-aliasing). Depth is never averaged over an edge."""

_PLATFORM_VARIABLE = "PYOPENGL_PLATFORM"

_opened: list[tuple[str, int]] = []
"""Platform and process of the first context. A process can have only one platform, and a fork of it none."""


class OpenGL:
    """A renderer that draws with OpenGL.

    Args:
        model: What to draw.
        platform: The OpenGL platform: EGL or OSMesa.
        width: Pixels.
        height: Pixels.

    Raises:
        BadValue: If this process has opened another platform, or was forked from one that has opened any.
        ImportError, AttributeError, RuntimeError: As MuJoCo and PyOpenGL raise them where the platform is missing or
            broken; :mod:`lockprobe_robot.rendering.choose_renderer` checks that beforehand.
    """

    def __init__(self, model: mujoco.MjModel, *, platform: Literal["egl", "osmesa"], width: int, height: int) -> None:
        self._model = copy.copy(model)
        self._model.vis.quality.offsamples = _SAMPLES
        self._model.vis.quality.shadowsize = _SHADOW_PIXELS
        self._model.vis.global_.offwidth = width
        self._model.vis.global_.offheight = height
        self._seen = mujoco.MjData(self._model)
        self._scene = mujoco.MjvScene(self._model, 2 * model.ngeom + 100)
        self._options = shown_options()
        self._window = mujoco.MjrRect(0, 0, width, height)
        self._context = _open_context(platform, width, height)
        # The context is current only while it is used, so that another thread can use it next.
        with self._context.as_current():
            self._drawing = mujoco.MjrContext(self._model, mujoco.mjtFontScale.mjFONTSCALE_100)
            mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._drawing)
            self.detail = _driver()
        # Depth 1 at the near plane and 0 at the far one: floats are densest where things are far.
        self._drawing.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
        self.name = title(platform, self.detail)

    def render(
        self, data: mujoco.MjData, camera: str, error: ViewError | None = None
    ) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """Colours, and depth along the optical axis in metres, 0 where there is nothing."""
        shown_state(self._model, data, self._seen)
        eye = mujoco.MjvCamera()
        eye.type = mujoco.mjtCamera.mjCAMERA_FIXED
        eye.fixedcamid = self._model.camera(camera).id
        if error is not None:
            error.move(self._seen, eye.fixedcamid)
        bodies = mujoco.mjtCatBit.mjCAT_STATIC | mujoco.mjtCatBit.mjCAT_DYNAMIC
        mujoco.mjv_updateScene(self._model, self._seen, self._options, None, eye, bodies, self._scene)
        with self._context.as_current():
            rgb, buffer = self._draw()
        return rgb[::-1].copy(), self._metres(buffer[::-1])

    def close(self) -> None:
        """Free the context."""
        with self._context.as_current():
            self._drawing.free()
        self._context.free()

    def _draw(self) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """Colours and the depth buffer, bottom row first."""
        rgb = np.empty((self._window.height, self._window.width, 3), np.uint8)
        mujoco.mjr_render(self._window, self._scene, self._drawing)
        mujoco.mjr_readPixels(rgb, None, self._window, self._drawing)
        buffer = np.empty((self._window.height, self._window.width), np.float32)
        flags = self._scene.flags.copy()
        # Flat colours are drawn without lights, shadows and several samples a pixel.
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SEGMENT] = True
        self._scene.flags[mujoco.mjtRndFlag.mjRND_IDCOLOR] = True
        mujoco.mjr_render(self._window, self._scene, self._drawing)
        mujoco.mjr_readPixels(None, buffer, self._window, self._drawing)
        self._scene.flags[:] = flags
        return rgb, buffer

    def _metres(self, buffer: NDArray[np.float32]) -> NDArray[np.float32]:
        """Linearise the depth buffer, which holds (near / z - near / far) / (1 - near / far)."""
        extent = self._model.stat.extent
        near = self._model.vis.map.znear * extent
        far = self._model.vis.map.zfar * extent
        depth = near / (buffer * np.float64(1 - near / far) + near / far)
        return np.where(buffer > 0, depth, 0).astype(np.float32)


def _open_context(platform: str, width: int, height: int) -> Any:
    if _opened:
        first, process = _opened[0]
        if process != os.getpid():
            raise BadValue(
                "renderer", platform, "no OpenGL in a process forked after it was opened: use spawn, or rays"
            )
        if first != platform:
            raise BadValue("renderer", platform, f"{first} or rays: this process has already opened {first}")
    before = os.environ.get(_PLATFORM_VARIABLE)
    try:
        context = importlib.import_module(f"mujoco.{platform}").GLContext(width, height)
    finally:
        if before is None:
            # The import set it for PyOpenGL, which has read it by now; child processes must not inherit it.
            os.environ.pop(_PLATFORM_VARIABLE, None)
    _opened.append((platform, os.getpid()))
    return context


def _driver() -> str:
    gl = importlib.import_module("OpenGL.GL")
    return bytes(gl.glGetString(gl.GL_RENDERER)).decode()
