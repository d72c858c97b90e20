"""Kinematics of Franka's arms with a hand, for real arms: joint angles for a pose of the tool.

The Panda and the FR3 have the same Denavit-Hartenberg parameters; their limits differ, and the narrower ones count.
"""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import PlantFault
from lockprobe_robot.arm.inverse_kinematics import InverseKinematics
from lockprobe_robot.arm.panda import JOINTS, add_panda
from lockprobe_robot.arm.protocol import Vector

_FR3_LOWER = np.array([-2.7437, -1.7837, -2.9007, -3.0421, -2.8065, 0.5445, -3.0159])
_FR3_UPPER = np.array([2.7437, 1.7837, 2.9007, -0.1518, 2.8065, 4.5169, 3.0159])
"""Joint limits of the FR3 from its data sheet, radians."""


class ArmKinematics:
    """Forward and inverse kinematics of the arm with a tool on its flange.

    Args:
        tool: Distance from the flange to the tool centre point (the top of a held knob), metres.
    """

    def __init__(self, tool: float) -> None:
        spec = mujoco.MjSpec()
        add_panda(spec).add_site(name="tool", pos=[0, 0, tool])
        self._model = spec.compile()
        self._data = mujoco.MjData(self._model)
        self._solver = InverseKinematics(self._model)

    def angles(self, position: Vector, axis: Vector) -> NDArray[np.float64]:
        """Inverse kinematics: joint angles, radians, shape (7,), for a tool position (metres) and a hand direction.

        Raises:
            PlantFault: If there is no solution within the limits of both arms.
        """
        found = self._solver.solve(np.asarray(position, dtype=np.float64), axis)
        if found is None or not ((found > _FR3_LOWER) & (found < _FR3_UPPER)).all():
            raise PlantFault(f"the arm cannot reach {np.round(position, 3).tolist()} (metres from its base)")
        return found

    def tool(self, angles: NDArray[np.float64]) -> NDArray[np.float64]:
        """Forward kinematics: pose of the tool in the frame of the base, shape (4, 4), metres."""
        self._data.qpos[:JOINTS] = angles
        mujoco.mj_kinematics(self._model, self._data)
        pose = np.eye(4)
        pose[:3, :3] = self._data.site("tool").xmat.reshape(3, 3)
        pose[:3, 3] = self._data.site("tool").xpos
        return pose
