"""What is seen of a model, whichever renderer draws it."""

from __future__ import annotations

import mujoco
import numpy as np

__all__ = ["SHOWN_GROUPS", "shown_options", "shown_state"]

SHOWN_GROUPS = (True, True, True, False, False, False)
"""Of geoms; whatever is hidden behind the panel lies in the others."""


def shown_options() -> mujoco.MjvOption:
    """Options under which OpenGL draws nothing but shown geoms."""
    options = mujoco.MjvOption()
    options.geomgroup[:] = SHOWN_GROUPS
    options.sitegroup[:] = False
    options.flags[mujoco.mjtVisFlag.mjVIS_TENDON] = False
    return options


def shown_state(model: mujoco.MjModel, data: mujoco.MjData, seen: mujoco.MjData) -> None:
    """Place everything in ``seen`` as in ``data``, which stays untouched down to its last bit."""
    everything = mujoco.mjtState.mjSTATE_PHYSICS | mujoco.mjtState.mjSTATE_USER
    state = np.empty(mujoco.mj_stateSize(model, everything))
    mujoco.mj_getState(model, data, state, everything)
    mujoco.mj_setState(model, seen, state, everything)
    mujoco.mj_kinematics(model, seen)
    mujoco.mj_comPos(model, seen)
    mujoco.mj_camlight(model, seen)
