"""What ``lockprobe doctor`` says of physical boxes: the simulation, and every renderer of pictures."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
from collections.abc import Iterator

from lockprobe.cli.doctor import Finding
from lockprobe.foundation.errors import UserMistake
from lockprobe_robot.rendering.choose_renderer import VARIABLE, decide, probe
from lockprobe_robot.simulation import require_mujoco

__all__ = ["examine"]


def examine() -> Iterator[Finding]:
    """Examine what a physical box needs."""
    yield _simulation()
    if importlib.util.find_spec("mujoco") is not None:
        yield from _renderers()


def _simulation() -> Finding:
    what = "physical lockbox"
    try:
        require_mujoco()
    except UserMistake as mistake:
        return Finding(what=what, ok=False, detail=str(mistake))
    return Finding(what=what, ok=True, detail=f"mujoco {importlib.metadata.version('mujoco')}")


def _renderers() -> Iterator[Finding]:
    """Each renderer of pictures, and the one that is used."""
    probed = probe()
    for one in probed:
        yield Finding(
            what=f"renderer {one.name}", ok=one.ok, detail=one.detail or "works everywhere, slower than OpenGL"
        )
    try:
        taken = decide()
    except UserMistake as mistake:
        yield Finding(what="renderer taken", ok=False, detail=str(mistake))
        return
    why = f"as {VARIABLE} says" if os.environ.get(VARIABLE) else "the first that works"
    yield Finding(
        what="renderer taken", ok=True, detail=f"{taken}, {why}; renderer=... in a plant's spec takes another"
    )
