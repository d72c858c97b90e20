"""Driver of Franka Emika's Panda through panda-py, as an arm for the guarded move: the only importer of ``panda_py``.

It was never run on a robot. Its calls follow panda-python 1.1.1.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import PlantFault, needing
from lockprobe.foundation.plugins import ROBOT
from lockprobe_robot.arm.hand import TOOL
from lockprobe_robot.arm.panda import HOME
from lockprobe_robot.arm.protocol import Vector
from lockprobe_robot.hardware.kinematics import ArmKinematics
from lockprobe_robot.hardware.wrench import FreshWrench

__all__ = ["PandaArm"]

_TURN_STIFFNESS = 60.0
"""Newton metres per radian that keep the hand's orientation."""


class PandaArm:
    """A Panda that follows moving targets under Cartesian impedance control.

    Args:
        host: Address of the robot's control unit.
        tool: Distance from the flange to the tool centre point (the top of a held knob), metres.
        wrench: A force-torque sensor; None for the robot's own estimate of the external wrench.
        period: Seconds between two commands; the 1 kHz loop is the library's.
        speed: Fraction of the highest speed in free motions, (0, 1].

    Raises:
        Missing: If panda-py is not installed.
    """

    def __init__(
        self,
        host: str,
        *,
        tool: float = TOOL,
        wrench: FreshWrench | None = None,
        period: float = 0.01,
        speed: float = 0.2,
    ) -> None:
        with needing("arms of the type Panda", "panda", ROBOT):
            import panda_py
            from panda_py import controllers
        self._controllers, self._wrench, self._period, self._speed = controllers, wrench, period, speed
        self._tool = np.eye(4)
        self._tool[2, 3] = tool
        self._kinematics = ArmKinematics(tool)
        self._panda: Any = panda_py.Panda(host)
        self._controller: Any = None
        self._stiffness, self._next = 0.0, 0.0
        self._posture = np.asarray(self._panda.q, dtype=np.float64)
        self._turn = self._pose()[:3, :3]

    @property
    def facts(self) -> Mapping[str, str]:
        """The library and the source of forces."""
        source = "robot's estimate" if self._wrench is None else "reader"
        return {"driver": f"panda-python {version('panda-python')}", "wrench": source}

    @property
    def period(self) -> float:
        """Duration of one call of :meth:`follow`, seconds."""
        return self._period

    @property
    def time(self) -> float:
        """Seconds of a monotonic clock."""
        return time.monotonic()

    @property
    def success_rate(self) -> float:
        """Share of the last 100 control commands that the robot received in time, [0, 1]."""
        return float(self._panda.get_state().control_command_success_rate)

    def home(self) -> None:
        """Go to the homing pose."""
        self._go(HOME)

    def reach(self, position: Vector, axis: Vector) -> None:
        """Go to a pose through joint space."""
        angles = self._kinematics.angles(position, axis)
        self._go(angles)
        self._posture, self._turn = angles, self._kinematics.tool(angles)[:3, :3]

    def follow(self, position: Vector, velocity: Vector, *, stiffness: float) -> None:
        """Follow a moving point for one period. The library takes no velocity: the target leads by half a period."""
        from scipy.spatial.transform import Rotation

        if self._controller is None:
            self._controller = self._controllers.CartesianImpedance(_gains(stiffness))
            self._panda.start_controller(self._controller)
            self._stiffness, self._next = stiffness, time.monotonic()
        elif stiffness != self._stiffness:
            self._controller.set_impedance(_gains(stiffness))
            self._stiffness = stiffness
        tool = np.eye(4)
        tool[:3, :3], tool[:3, 3] = self._turn, position + 0.5 * self._period * velocity
        target = tool @ np.linalg.inv(self._tool) @ self._effector()
        quaternion = Rotation.from_matrix(target[:3, :3]).as_quat()
        self._controller.set_control(target[:3, 3], quaternion, self._posture)
        self._next += self._period
        time.sleep(max(0.0, self._next - time.monotonic()))
        self._panda.raise_error()

    def position(self) -> Vector:
        """Position of the tool, metres."""
        return np.asarray(self._pose()[:3, 3])

    def force(self) -> Vector:
        """Force on the hand, newtons, in the frame of the base; the robot's estimate is of the opposite force."""
        if self._wrench is None:
            return -np.asarray(self._panda.get_state().O_F_ext_hat_K, dtype=np.float64)[:3]
        return self._wrench.force(self._pose()[:3, :3])

    def stop(self) -> None:
        """Abort every motion; the robot brakes by itself."""
        self._controller = None
        self._panda.get_robot().stop()

    def _go(self, angles: NDArray[np.float64]) -> None:
        if self._controller is not None:
            self._panda.stop_controller()
            self._controller = None
        self._panda.recover()
        if not self._panda.move_to_joint_position(angles, speed_factor=self._speed):
            raise PlantFault("the arm did not arrive at its joint angles")

    def _effector(self) -> NDArray[np.float64]:
        """The configured end effector in the frame of the flange."""
        return np.asarray(self._panda.get_state().F_T_EE, dtype=np.float64).reshape(4, 4, order="F")

    def _pose(self) -> NDArray[np.float64]:
        """Pose of the tool in the frame of the base."""
        flange = np.asarray(self._panda.get_pose(), dtype=np.float64) @ np.linalg.inv(self._effector())
        return np.asarray(flange @ self._tool)


def _gains(stiffness: float) -> NDArray[np.float64]:
    return np.diag([stiffness] * 3 + [_TURN_STIFFNESS] * 3)
