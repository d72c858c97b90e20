"""The interface of renderers, their names in records, and the shown parts of a model."""

from __future__ import annotations

import importlib.metadata
from typing import Protocol

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe_robot.geom_groups import SHOWN_GROUPS
from lockprobe_robot.rendering.view_error import ViewError

__all__ = ["Renderer", "shown_options", "shown_state", "title"]


class Renderer(Protocol):
    """Makes pictures of one model. Threads may take turns with it, one at a time."""

    @property
    def name(self) -> str:
        """Its name with versions, for the record."""
        ...

    def render(
        self, data: mujoco.MjData, camera: str, error: ViewError | None = None
    ) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """Draw what a camera sees. The state is read and not changed.

        Args:
            data: State of the model.
            camera: Name of a camera of the model.
            error: How far the camera is from its place in the model.

        Returns:
            Colours, shape (height, width, 3); depth along the optical axis in metres, shape (height, width), 0 where
            there is nothing.
        """
        ...

    def close(self) -> None:
        """Release its resources."""
        ...


def title(name: str, detail: str) -> str:
    """A renderer's name in records, with versions."""
    engine = f"mujoco {importlib.metadata.version('mujoco')}"
    return f"{name} ({engine}, {detail})" if detail else f"{name} ({engine})"


def shown_options() -> mujoco.MjvOption:
    """Options under which OpenGL draws only the shown geoms."""
    options = mujoco.MjvOption()
    options.geomgroup[:] = SHOWN_GROUPS
    options.sitegroup[:] = False
    options.flags[mujoco.mjtVisFlag.mjVIS_TENDON] = False
    return options


def shown_state(model: mujoco.MjModel, data: mujoco.MjData, seen: mujoco.MjData) -> None:
    """Copy the state ``data`` into ``seen`` and compute all poses there. ``data`` keeps every bit."""
    everything = mujoco.mjtState.mjSTATE_PHYSICS | mujoco.mjtState.mjSTATE_USER
    state = np.empty(mujoco.mj_stateSize(model, everything))
    mujoco.mj_getState(model, data, state, everything)
    mujoco.mj_setState(model, seen, state, everything)
    mujoco.mj_kinematics(model, seen)
    mujoco.mj_comPos(model, seen)
    mujoco.mj_camlight(model, seen)
