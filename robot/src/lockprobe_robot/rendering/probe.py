"""Probes whether OpenGL draws on this machine, before a renderer is opened.

A missing or broken graphics library can end a process or make ``import mujoco`` fail. So it is tried in a separate
process, and importing this module imports neither MuJoCo nor OpenGL.
"""

from __future__ import annotations

import ctypes.util
import functools
import importlib
import importlib.util
import os
import signal
import subprocess
import sys
from dataclasses import dataclass
from typing import TYPE_CHECKING

from lockprobe.foundation.errors import BadValue, Missing
from lockprobe.foundation.safe_path import interpreter, safe_path

if TYPE_CHECKING:
    import mujoco

    from lockprobe_robot.rendering.opengl import OpenGL

_REMEDY = "install libEGL and Mesa's drivers (Debian: libegl1 libopengl0 libegl-mesa0 libgl1-mesa-dri)"

_PLATFORMS = ("MUJOCO_GL", "PYOPENGL_PLATFORM")
"""Variables that make MuJoCo or PyOpenGL load a platform when imported; probes run without them."""

_TIMEOUT = 60.0
"""Seconds after which a probe counts as hanging."""

_PROBE = """
import sys
sys.path[:] = sys.argv[1:]
import mujoco
from lockprobe_robot.rendering.opengl import OpenGL
model = mujoco.MjModel.from_xml_string(
    "<mujoco><worldbody><geom name='ball' size='1'/><camera name='eye' pos='0 0 3'/></worldbody></mujoco>"
)
renderer = OpenGL(model, width=64, height=64)
rgb, depth = renderer.render(mujoco.MjData(model), "eye")
assert abs(depth[32, 32] - 2) < 0.01 and rgb[32, 32].any(), "it draws nothing"
print(renderer.name)
renderer.close()
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Probed:
    """The result of a probe.

    Attributes:
        ok: Whether the test picture was drawn correctly.
        detail: The renderer's name with versions and driver, or the reason why it does not work, in one line.
    """

    ok: bool
    detail: str


@functools.cache
def probe() -> Probed:
    """Draw a test picture in a separate process. The result is cached."""
    if importlib.util.find_spec("mujoco") is None:
        return Probed(ok=False, detail="the package mujoco is not installed")
    try:
        with safe_path():
            done = subprocess.run(  # noqa: S603 - this interpreter and the program above
                interpreter("-c", _PROBE, *sys.path),
                capture_output=True,
                text=True,
                timeout=_TIMEOUT,
                check=False,
                env={name: value for name, value in os.environ.items() if name not in _PLATFORMS},
            )
    except subprocess.TimeoutExpired:
        return Probed(ok=False, detail=f"it hung for {_TIMEOUT:.0f} s")
    if done.returncode == 0:
        return Probed(ok=True, detail=done.stdout.strip())
    return Probed(ok=False, detail=_reason(done))


def require_mujoco() -> None:
    """Check that boxes can be simulated and drawn here.

    Raises:
        Missing: If a package is missing.
        BadValue: If ``MUJOCO_GL`` names an OpenGL platform that is not there, so that MuJoCo cannot be imported.
    """
    for module, package in (("mujoco", "mujoco"), ("PIL", "pillow")):
        if importlib.util.find_spec(module) is None:
            raise Missing(f"the twins need the package {package}", "pip install 'lockprobe[twin]'")
    if platform := os.environ.get("MUJOCO_GL"):
        try:
            importlib.import_module("mujoco")
        except (AttributeError, ImportError, RuntimeError):
            raise BadValue("MUJOCO_GL", platform, "a platform that works here; unset it, it is not needed") from None


def require_opengl() -> None:
    """Check that pictures can be drawn here.

    Raises:
        Missing: If OpenGL does not work here.
    """
    if not probe().ok:
        raise Missing(f"pictures need OpenGL, which does not work here ({probe().detail})", _REMEDY)


def open_renderer(model: mujoco.MjModel, *, width: int, height: int) -> OpenGL:
    """Open a renderer of a model.

    Raises:
        BadValue: If this process was forked from one that had opened a renderer.
        Missing: If OpenGL does not work here.
    """
    require_opengl()
    from lockprobe_robot.rendering.opengl import OpenGL

    return OpenGL(model, width=width, height=height)


def renderer_name() -> str:
    """The name, with versions, of what :func:`open_renderer` would open. Nothing is opened here.

    Raises:
        Missing: If OpenGL does not work here.
    """
    require_opengl()
    return probe().detail


def _reason(done: subprocess.CompletedProcess[str]) -> str:
    if done.returncode < 0:
        return f"it ended with {signal.Signals(-done.returncode).name}"
    if sys.platform != "darwin" and ctypes.util.find_library("EGL") is None:
        return "no libEGL on this machine"
    lines = done.stderr.strip().splitlines()
    return lines[-1].strip() if lines else f"exit status {done.returncode}"
