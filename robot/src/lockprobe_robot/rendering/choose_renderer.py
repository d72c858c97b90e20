"""Probes which renderers work on this machine, and chooses one.

A missing or broken graphics library can end a process or make ``import mujoco`` fail. So every renderer is tried in a
separate process, and importing this module imports neither MuJoCo nor OpenGL.
"""

from __future__ import annotations

import ctypes.util
import functools
import importlib.util
import os
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, get_args

from lockprobe.foundation.errors import BadValue, Missing
from lockprobe.foundation.safe_path import interpreter, safe_path
from lockprobe_robot.twin_settings import RendererChoice

if TYPE_CHECKING:
    import mujoco

    from lockprobe_robot.rendering.renderer import Renderer

__all__ = ["RENDERERS", "VARIABLE", "Probed", "chosen_renderer", "decide", "open_renderer", "probe", "probe_one"]

VARIABLE = "LOCKPROBE_RENDERER"
"""Environment variable that says what ``auto`` takes."""

RendererName = Literal["egl", "osmesa", "rays"]

RENDERERS: tuple[RendererName, ...] = get_args(RendererName)
"""All renderers, in the order in which ``auto`` tries them."""

_REMEDIES: dict[RendererName, str] = {
    "egl": "install libEGL and Mesa's drivers (Debian: libegl1 libopengl0 libgl1-mesa-dri), or take renderer=rays",
    "osmesa": "install libOSMesa (Debian: libosmesa6), or take renderer=rays",
    "rays": "pip install 'lockprobe[twin]'",
}

_LIBRARIES: dict[RendererName, str] = {"egl": "EGL", "osmesa": "OSMesa"}

_PLATFORMS = ("MUJOCO_GL", "PYOPENGL_PLATFORM")
"""Variables that make MuJoCo or PyOpenGL load a platform when imported; probes run without them."""

_TIMEOUT = 60.0
"""Seconds after which a probe counts as hanging."""

_PROBE = """
import sys
name = sys.argv[1]
sys.path[:] = sys.argv[2:]
import mujoco
model = mujoco.MjModel.from_xml_string(
    "<mujoco><worldbody><geom name='ball' size='1'/><camera name='eye' pos='0 0 3'/></worldbody></mujoco>"
)
if name == "rays":
    from lockprobe_robot.rendering.ray_caster import RayCaster
    renderer = RayCaster(model, width=64, height=64)
else:
    from lockprobe_robot.rendering.opengl import OpenGL
    renderer = OpenGL(model, platform=name, width=64, height=64)
data = mujoco.MjData(model)
rgb, depth = renderer.render(data, "eye")
assert abs(depth[32, 32] - 2) < 0.01 and rgb[32, 32].any(), "it draws nothing"
print(renderer.detail)
renderer.close()
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Probed:
    """The result of probing one renderer.

    Attributes:
        name: The renderer.
        ok: Whether it drew the test picture correctly.
        detail: The driver's name, or the reason why the renderer does not work, in one line.
    """

    name: RendererName
    ok: bool
    detail: str


def probe() -> tuple[Probed, ...]:
    """Probe every renderer, in the order in which ``auto`` tries them. Results are cached."""
    with ThreadPoolExecutor(len(RENDERERS)) as pool:
        return tuple(pool.map(probe_one, RENDERERS))


@functools.cache
def probe_one(name: RendererName) -> Probed:
    """Probe one renderer in a separate process. The result is cached."""
    if importlib.util.find_spec("mujoco") is None:
        return Probed(name=name, ok=False, detail="the package mujoco is not installed")
    try:
        with safe_path():
            done = subprocess.run(  # noqa: S603 - this interpreter and the program above
                interpreter("-c", _PROBE, name, *sys.path),
                capture_output=True,
                text=True,
                timeout=_TIMEOUT,
                check=False,
                env={name: value for name, value in os.environ.items() if name not in _PLATFORMS},
            )
    except subprocess.TimeoutExpired:
        return Probed(name=name, ok=False, detail=f"it hung for {_TIMEOUT:.0f} s")
    if done.returncode == 0:
        return Probed(name=name, ok=True, detail=done.stdout.strip())
    return Probed(name=name, ok=False, detail=_reason(name, done))


def decide(choice: RendererChoice = "auto") -> RendererName:
    """Resolve a choice to a renderer.

    ``auto`` stands for the one in the environment variable LOCKPROBE_RENDERER, or the first that works here.

    Raises:
        BadValue: If there is no such renderer.
        Missing: If it does not work here, or no renderer does.
    """
    what, asked = "renderer", str(choice)
    if choice == "auto":
        what, asked = VARIABLE, os.environ.get(VARIABLE, "").strip() or "auto"
    if asked not in get_args(RendererChoice):
        raise BadValue(what, asked, f"one of {', '.join(get_args(RendererChoice))}")
    for name in RENDERERS:
        if name == asked or (asked == "auto" and probe_one(name).ok):
            return _working(name)
    return _working(RENDERERS[-1])


def open_renderer(model: mujoco.MjModel, *, width: int, height: int, choice: RendererChoice = "auto") -> Renderer:
    """Open a renderer of a model.

    Args:
        model: What to draw.
        width: Pixels.
        height: Pixels.
        choice: As in :func:`decide`.

    Raises:
        BadValue: If there is no such renderer, or this process cannot have it any more.
        Missing: If it does not work here.
    """
    name = decide(choice)
    if name == "rays":
        from lockprobe_robot.rendering.ray_caster import RayCaster

        return RayCaster(model, width=width, height=height)
    from lockprobe_robot.rendering.opengl import OpenGL

    return OpenGL(model, platform=name, width=width, height=height)


def chosen_renderer(choice: RendererChoice = "auto") -> str:
    """The name, with versions, of the renderer that :func:`open_renderer` would open. Nothing is opened here.

    Raises:
        BadValue: If there is no such renderer.
        Missing: If it does not work here.
    """
    name = decide(choice)
    from lockprobe_robot.rendering.renderer import title

    return title(name, probe_one(name).detail)


def _working(name: RendererName) -> RendererName:
    probed = probe_one(name)
    if not probed.ok:
        raise Missing(f"renderer {name} does not work here ({probed.detail})", _REMEDIES[name])
    return name


def _reason(name: RendererName, done: subprocess.CompletedProcess[str]) -> str:
    if done.returncode < 0:
        return f"it ended with {signal.Signals(-done.returncode).name}"
    library = _LIBRARIES.get(name, "")
    if library and ctypes.util.find_library(library) is None:
        return f"no lib{library} on this machine"
    lines = done.stderr.strip().splitlines()
    return lines[-1].strip() if lines else f"exit status {done.returncode}"
