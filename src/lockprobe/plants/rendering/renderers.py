"""Which renderer makes the pictures: the one asked for, or the first that works here."""

from __future__ import annotations

from typing import Protocol

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe.plants.rendering.probing import decide, probe_one, title
from lockprobe.plants.settings import RendererChoice

__all__ = ["Renderer", "chosen_renderer", "open_renderer"]


class Renderer(Protocol):
    """Makes pictures of one model. Threads may take turns with it, one at a time."""

    @property
    def name(self) -> str:
        """What it is, with versions, for the record."""
        ...

    def render(self, data: mujoco.MjData, camera: str) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """What a camera sees. The state is read and not changed.

        Args:
            data: State of the model.
            camera: Name of a camera of the model.

        Returns:
            Colours, shape (height, width, 3); depth along the optical axis in metres, shape (height, width), 0 where
            there is nothing.
        """
        ...

    def close(self) -> None:
        """Let go of what it holds."""
        ...


def open_renderer(model: mujoco.MjModel, *, width: int, height: int, choice: RendererChoice = "auto") -> Renderer:
    """A renderer of a model.

    Args:
        model: What is to be seen.
        width: Pixels.
        height: Pixels.
        choice: Which; ``auto`` is what the environment variable LOCKPROBE_RENDERER says, or else the first of EGL,
            OSMesa and the ray caster that works here.

    Raises:
        BadValue: If there is no such renderer, or this process cannot have it any more.
        Missing: If it does not work here.
    """
    name = decide(choice)
    if name == "rays":
        from lockprobe.plants.rendering.rays import RayCaster

        return RayCaster(model, width=width, height=height)
    from lockprobe.plants.rendering.opengl import OpenGL

    return OpenGL(model, platform=name, width=width, height=height)


def chosen_renderer(choice: RendererChoice = "auto") -> str:
    """The name, with versions, of what :func:`open_renderer` would open; nothing is opened in this process.

    Raises:
        BadValue: If there is no such renderer.
        Missing: If it does not work here.
    """
    name = decide(choice)
    return title(name, probe_one(name).detail)
