"""What every simulated plant needs: MuJoCo on this machine."""

from __future__ import annotations

import importlib.util
import os

from lockprobe.foundation.errors import BadValue, Missing


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
