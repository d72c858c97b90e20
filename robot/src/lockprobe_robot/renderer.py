"""Pictures of a MuJoCo model, off screen: EGL or OSMesa on Linux, CGL on macOS.

``mujoco.Renderer`` would make a graphics context for every model, which takes most of a second: here a thread has one.
"""

from __future__ import annotations

import copy
import functools
import importlib
import os
import sys
import threading
from typing import Any

import mujoco
import numpy as np
from mujoco.rendering.classic import gl_context
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue, Missing
from lockprobe_robot.geom_groups import SHOWN_GROUPS

_REMEDY = "install libEGL and Mesa's drivers (Debian: libegl1 libopengl0 libegl-mesa0 libgl1-mesa-dri)"

_SHADOW_PIXELS = 2048
_SAMPLES = 4
"""Samples per pixel of colour pictures (anti-aliasing). Depth is never averaged over an edge."""

_FAR = 0.99
"""Share of the farthest distance that is drawn, from which on there is nothing."""

_here = threading.local()
"""The graphics context of each thread, in which all of its renderers draw."""

_opened: list[int] = []
"""The process of the first renderer. The graphics library's threads do not survive a fork: every call would hang."""


class Renderer:
    """A renderer of a model, for one thread; sizes are in pixels.

    Attributes:
        name: The platform, with versions and driver.
        seen: The state that is drawn, with the poses of all geoms, lights and cameras.

    Raises:
        BadValue: If this process was forked from one that has opened a renderer.
        Missing: If nothing can be drawn here.
    """

    def __init__(self, model: mujoco.MjModel, *, width: int, height: int) -> None:
        if _opened and _opened[0] != os.getpid():
            raise BadValue("renderer", "OpenGL", "none in a process forked after it was opened: use spawn")
        self._model = copy.copy(model)
        self._model.vis.quality.offsamples, self._model.vis.quality.shadowsize = _SAMPLES, _SHADOW_PIXELS
        self._model.vis.global_.offwidth, self._model.vis.global_.offheight = width, height
        self.seen = mujoco.MjData(self._model)
        self._options = mujoco.MjvOption()
        self._options.geomgroup[:] = SHOWN_GROUPS
        self._options.sitegroup[:] = False
        self._options.flags[mujoco.mjtVisFlag.mjVIS_TENDON] = False
        self._rect = mujoco.MjrRect(0, 0, width, height)
        self._scene = mujoco.MjvScene(self._model, maxgeom=2 * model.ngeom + 100)
        try:
            if not hasattr(_here, "context"):
                _here.context = gl_context.GLContext(width, height)
            self._context: Any = _here.context
            self._context.make_current()
            self._drawn = mujoco.MjrContext(self._model, mujoco.mjtFontScale.mjFONTSCALE_150)
            self._drawn.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
            gl = importlib.import_module("OpenGL.GL")
            driver = bytes(gl.glGetString(gl.GL_RENDERER)).decode()
        except (AttributeError, ImportError, OSError, RuntimeError, mujoco.FatalError) as error:
            raise Missing(f"pictures need OpenGL, which does not work here ({error})", _REMEDY) from None
        _opened.append(os.getpid())
        platform = os.environ.get("MUJOCO_GL") or ("cgl" if sys.platform == "darwin" else "glfw")
        self.name = f"{platform} (mujoco {mujoco.__version__}, {driver})"

    def pose(self, data: mujoco.MjData) -> mujoco.MjData:
        """Take over a state of the model, which keeps every bit, and compute all poses in :attr:`seen`."""
        mujoco.mj_copyData(self.seen, self._model, data)
        mujoco.mj_kinematics(self._model, self.seen)
        mujoco.mj_comPos(self._model, self.seen)
        mujoco.mj_camlight(self._model, self.seen)
        return self.seen

    def colours(self, camera: str) -> NDArray[np.uint8]:
        """What a camera sees of :attr:`seen`, shape (height, width, 3)."""
        rgb = np.empty((self._rect.height, self._rect.width, 3), dtype=np.uint8)
        self._draw(camera, rgb, None)
        return np.flipud(rgb).copy()

    def depth(self, camera: str) -> NDArray[np.float32]:
        """Depth along the optical axis, shape (height, width), metres; 0 where there is nothing."""
        read = np.empty((self._rect.height, self._rect.width), dtype=np.float32)
        self._draw(camera, None, read)
        clip, extent = self._model.vis.map, self._model.stat.extent
        near, far = np.float32(clip.znear * extent), np.float32(clip.zfar * extent)
        beyond = np.float32(0.5) * ((far + near) / (far - near)) - np.float32(0.5)
        depth = (far * near / (far - near) / (read.astype(np.float64) + beyond)).astype(np.float32)
        return np.flipud(np.where(depth < _FAR * far, depth, np.float32(0)))

    def _draw(self, camera: str, rgb: NDArray[np.uint8] | None, depth: NDArray[np.float32] | None) -> None:
        """Draw what a camera sees, from the bottom up."""
        eye = mujoco.MjvCamera()
        eye.type, eye.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, self._model.camera(camera).id
        everything = mujoco.mjtCatBit.mjCAT_ALL
        mujoco.mjv_updateScene(self._model, self.seen, self._options, None, eye, everything, self._scene)
        for plain in (mujoco.mjtRndFlag.mjRND_SEGMENT, mujoco.mjtRndFlag.mjRND_IDCOLOR):
            self._scene.flags[plain] = depth is not None  # depth is more accurate without light
        self._context.make_current()
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._drawn)  # another renderer drew into its own
        mujoco.mjr_render(self._rect, self._scene, self._drawn)
        mujoco.mjr_readPixels(rgb, depth, self._rect, self._drawn)

    def close(self) -> None:
        """Free what it drew with."""
        self._context.make_current()
        self._drawn.free()


@functools.cache
def renderer_name() -> str:
    """The name of what draws here.

    Raises:
        Missing: If nothing does.
    """
    ball = "<mujoco><worldbody><geom size='1'/><camera name='eye' pos='0 0 3'/></worldbody></mujoco>"
    model = mujoco.MjModel.from_xml_string(ball)
    renderer = Renderer(model, width=64, height=64)
    renderer.pose(mujoco.MjData(model))
    drawn = abs(renderer.depth("eye")[32, 32] - 2) < 0.01
    renderer.close()
    if not drawn:
        raise Missing(f"pictures need OpenGL, which draws nothing here ({renderer.name})", _REMEDY)
    return renderer.name
