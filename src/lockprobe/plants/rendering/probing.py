"""Which renderers work on this machine, each tried in a process of its own, and which of them is taken.

A missing or broken graphics library can end a process or make ``import mujoco`` fail, so nothing is tried here.
"""

from __future__ import annotations

import ctypes.util
import functools
import importlib.metadata
import importlib.util
import os
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Literal, get_args

from lockprobe.errors import BadValue, Missing
from lockprobe.plants.settings import RendererChoice

__all__ = ["RENDERERS", "VARIABLE", "Probed", "RendererName", "automatic", "decide", "probe", "probe_one", "title"]

VARIABLE = "LOCKPROBE_RENDERER"
"""Environment variable that says what ``auto`` takes."""

RendererName = Literal["egl", "osmesa", "rays"]

RENDERERS: tuple[RendererName, ...] = get_args(RendererName)
"""In the order in which ``auto`` tries them."""

_REMEDIES: dict[RendererName, str] = {
    "egl": "install libEGL and Mesa's drivers (Debian: libegl1 libgl1-mesa-dri), or take renderer=rays",
    "osmesa": "install libOSMesa (Debian: libosmesa6), or take renderer=rays",
    "rays": "pip install 'lockprobe[twin]'",
}

_LIBRARIES: dict[RendererName, str] = {"egl": "EGL", "osmesa": "OSMesa"}

_PLATFORMS = ("MUJOCO_GL", "PYOPENGL_PLATFORM")
"""Variables that make an import ask for a platform; what is tried asks for its own."""

_PATIENCE = 60.0
"""Seconds after which a renderer that is being tried counts as one that hangs."""

_TRIAL = """
import sys
name = sys.argv[1]
sys.path[:] = sys.argv[2:]
import mujoco
model = mujoco.MjModel.from_xml_string(
    "<mujoco><worldbody><geom name='ball' size='1'/><camera name='eye' pos='0 0 3'/></worldbody></mujoco>"
)
if name == "rays":
    from lockprobe.plants.rendering.rays import RayCaster
    renderer = RayCaster(model, width=64, height=64)
else:
    from lockprobe.plants.rendering.opengl import OpenGL
    renderer = OpenGL(model, platform=name, width=64, height=64)
data = mujoco.MjData(model)
rgb, depth = renderer.render(data, "eye")
assert abs(depth[32, 32] - 2) < 0.01 and rgb[32, 32].any(), "it draws nothing"
print(renderer.detail)
renderer.close()
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Probed:
    """Whether a renderer works.

    Attributes:
        name: Which.
        ok: Whether it drew what it should have.
        detail: What draws, as the driver calls itself, or why it does not work, on one line.
    """

    name: RendererName
    ok: bool
    detail: str


def probe() -> tuple[Probed, ...]:
    """Every renderer, in the order in which ``auto`` tries them; found out once for a process."""
    with ThreadPoolExecutor(len(RENDERERS)) as pool:
        return tuple(pool.map(probe_one, RENDERERS))


@functools.cache
def probe_one(name: RendererName) -> Probed:
    """One renderer, tried in a process of its own; found out once for a process."""
    if importlib.util.find_spec("mujoco") is None:
        return Probed(name=name, ok=False, detail="the package mujoco is not installed")
    try:
        done = subprocess.run(  # noqa: S603 - this interpreter, and a program that stands above
            [sys.executable, "-c", _TRIAL, name, *sys.path],
            capture_output=True,
            text=True,
            timeout=_PATIENCE,
            check=False,
            env={name: value for name, value in os.environ.items() if name not in _PLATFORMS},
        )
    except subprocess.TimeoutExpired:
        return Probed(name=name, ok=False, detail=f"it hung for {_PATIENCE:.0f} s")
    if done.returncode == 0:
        return Probed(name=name, ok=True, detail=done.stdout.strip())
    return Probed(name=name, ok=False, detail=_reason(name, done))


def automatic() -> RendererName:
    """What ``auto`` takes: what the environment variable says, or else the first that works here.

    Raises:
        BadValue: If the environment variable names no renderer.
        Missing: If what it names does not work here, or none does.
    """
    asked = os.environ.get(VARIABLE, "").strip()
    if asked and asked not in get_args(RendererChoice):
        raise BadValue(VARIABLE, asked, f"one of {', '.join(get_args(RendererChoice))}")
    if asked in RENDERERS:
        return _working(asked)
    for name in RENDERERS[:-1]:
        if probe_one(name).ok:
            return name
    return _working(RENDERERS[-1])


def decide(choice: RendererChoice) -> RendererName:
    """The renderer that a choice stands for.

    Raises:
        BadValue: If there is no such renderer.
        Missing: If it does not work here.
    """
    if choice not in get_args(RendererChoice):
        raise BadValue("renderer", choice, f"one of {', '.join(get_args(RendererChoice))}")
    return automatic() if choice == "auto" else _working(choice)


def _working(name: RendererName) -> RendererName:
    probed = probe_one(name)
    if not probed.ok:
        raise Missing(f"renderer {name} does not work here ({probed.detail})", _REMEDIES[name])
    return name


def title(name: RendererName, detail: str) -> str:
    """A renderer's name in records, with versions."""
    engine = f"mujoco {importlib.metadata.version('mujoco')}"
    return f"{name} ({engine}, {detail})" if detail else f"{name} ({engine})"


def _reason(name: RendererName, done: subprocess.CompletedProcess[str]) -> str:
    if done.returncode < 0:
        return f"it ended with {signal.Signals(-done.returncode).name}"
    library = _LIBRARIES.get(name, "")
    if library and ctypes.util.find_library(library) is None:
        return f"no lib{library} on this machine"
    lines = done.stderr.strip().splitlines()
    return lines[-1].strip() if lines else f"exit status {done.returncode}"
