"""What ``lockprobe doctor`` says of physical boxes: the simulation, and the renderer of pictures."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Iterator

from lockprobe.foundation.errors import UserMistake
from lockprobe_robot.plants import renderer


def examine() -> Iterator[tuple[str, bool, str]]:
    """Examine what a physical box needs."""
    yield "physical lockbox", True, f"mujoco {importlib.metadata.version('mujoco')}"
    try:
        yield "renderer", True, renderer()
    except UserMistake as mistake:
        yield "renderer", False, str(mistake)
