"""The error of a camera's view: a small shift and rotation of which the robot does not know."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ViewError:
    """How far a camera is from where it should be.

    Attributes:
        shift: Along the camera's own axes, shape (3,), metres.
        turn: Rotation vector about these axes, shape (3,), radians.
    """

    shift: NDArray[np.float64]
    turn: NDArray[np.float64]

    def move(self, seen: mujoco.MjData, eye: int) -> None:
        """Move a camera of a state whose poses are computed, by index."""
        axes = seen.cam_xmat[eye].reshape(3, 3).copy()
        quaternion, rotation = np.zeros(4), np.zeros(9)
        angle = float(np.linalg.norm(self.turn))
        mujoco.mju_axisAngle2Quat(quaternion, self.turn / max(angle, 1e-12), angle)
        mujoco.mju_quat2Mat(rotation, quaternion)
        seen.cam_xpos[eye] += axes @ self.shift
        seen.cam_xmat[eye] = (axes @ rotation.reshape(3, 3)).ravel()


def draw_view_error(shift: float, turn: float, rng: np.random.Generator) -> ViewError | None:
    """The error of one picture: the same luck, scaled. Six numbers are drawn, whatever the sizes are.

    Args:
        shift: Standard deviation along each axis, metres.
        turn: Standard deviation about each axis, radians.
        rng: Random stream.

    Returns:
        None where both are 0.
    """
    luck = rng.standard_normal(6)
    return ViewError(shift=shift * luck[:3], turn=turn * luck[3:]) if shift or turn else None
