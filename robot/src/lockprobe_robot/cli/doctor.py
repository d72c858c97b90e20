"""What ``lockprobe doctor`` says of physical boxes: the simulation, and the renderer of pictures."""

from __future__ import annotations

import importlib.metadata
import importlib.util
from collections.abc import Iterator

from lockprobe.cli.doctor import Finding
from lockprobe.foundation.errors import UserMistake
from lockprobe_robot.rendering.probe import probe, require_mujoco


def examine() -> Iterator[Finding]:
    """Examine what a physical box needs."""
    yield _simulation()
    if importlib.util.find_spec("mujoco") is not None:
        yield Finding(what="renderer", ok=probe().ok, detail=probe().detail)


def _simulation() -> Finding:
    what = "physical lockbox"
    try:
        require_mujoco()
    except UserMistake as mistake:
        return Finding(what=what, ok=False, detail=str(mistake))
    return Finding(what=what, ok=True, detail=f"mujoco {importlib.metadata.version('mujoco')}")
