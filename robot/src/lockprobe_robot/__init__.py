"""Lockprobe on physical boxes: the MuJoCo twin with its robot arm, films, calibration, and adapters of real robots.

MuJoCo draws with what the variable ``MUJOCO_GL`` names. Where nobody has set it, this package sets it on Linux: to
``egl`` if that library is there, else to ``osmesa`` if that one is. On a Mac MuJoCo itself takes CGL.
"""

from __future__ import annotations

import importlib
import os
import sys
from ctypes.util import find_library
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import mujoco

    from lockprobe.boxes.box import Lockbox

__all__ = ["scene"]

if sys.platform == "linux" and "MUJOCO_GL" not in os.environ:
    _there = [platform for platform, library in (("egl", "EGL"), ("osmesa", "OSMesa")) if find_library(library)]
    if _there:
        os.environ["MUJOCO_GL"] = _there[0]
    if _there and (_read := sys.modules.get("mujoco.rendering.classic.gl_context")):
        importlib.reload(_read)  # MuJoCo, which was imported before, has read the variable


def scene(box: Lockbox, *, arm: bool = False) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """A box as a plain MuJoCo model, and its state at the start of a trial.

    ``lockprobe box show NAME --out scene.xml`` writes the same model.

    Args:
        box: The box, for example ``lockprobe.box("chain-4")``.
        arm: Whether the arm stands before it, with motors and force sensor.

    Raises:
        BadValue: If the box cannot be built.
    """
    import mujoco

    from lockprobe_robot.box_model.mjcf import plain_scene

    model = plain_scene(box, arm=arm).compile()
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    return model, data
