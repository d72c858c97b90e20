"""What ``lockprobe doctor`` says of physical boxes: the simulation, and the renderer of pictures."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Iterator

from lockprobe.cli.doctor import Finding
from lockprobe.foundation.errors import UserMistake
from lockprobe_robot.plants import renderer


def examine() -> Iterator[Finding]:
    """Examine what a physical box needs."""
    yield Finding(what="physical lockbox", ok=True, detail=f"mujoco {importlib.metadata.version('mujoco')}")
    try:
        yield Finding(what="renderer", ok=True, detail=renderer())
    except UserMistake as mistake:
        yield Finding(what="renderer", ok=False, detail=str(mistake))
