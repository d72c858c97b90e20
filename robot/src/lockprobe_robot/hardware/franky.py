"""Driver of Franka's FR3 through franky, as an arm for the guarded move: the only importer of ``franky``."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from importlib.metadata import version
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import PlantFault, needing
from lockprobe.foundation.plugins import ROBOT
from lockprobe_robot.arm.inverse_kinematics import InverseKinematics
from lockprobe_robot.arm.model import HOME, JOINTS, TOOL, TOOL_SITE, add_arm
from lockprobe_robot.arm.protocol import Vector

_TURN_STIFFNESS = 60.0
"""Newton metres per radian that keep the hand's orientation."""

_GAINS_SECONDS = 0.02
"""Time constant of the gains. With the library's 0.1 s the first part of a drag is too soft."""

_PERIOD, _SPEED = 0.01, 0.2
"""Seconds between two commands (the 1 kHz loop is the library's); share of the highest speed, acceleration and jerk in
free motions."""

_COLLISION = 60.0
"""Collision threshold in newtons; half of the number is that of torques in newton metres."""

_LONGEST_JOIN = 10.0
"""Longest wait for the end of a motion that was told to end, seconds."""

_LOWER = np.array([-2.7437, -1.7837, -2.9007, -3.0421, -2.8065, 0.5445, -3.0159])
_UPPER = np.array([2.7437, 1.7837, 2.9007, -0.1518, 2.8065, 4.5169, 3.0159])
"""Joint limits of the FR3 from its data sheet, radians. Its Denavit-Hartenberg parameters are those of the Panda, whose
limits count, too."""


class FrankyArm:
    """An FR3 that follows moving targets under Cartesian impedance control.

    Args:
        host: Address of the robot's control unit.
        tool: Distance from the flange to the tool centre point (the top of a held knob), metres.
        wrench: Reads a force-torque sensor: the force on the hand in the frame of the flange, newtons, shape (3,). It
            has to raise where its reading is old. None for the robot's own estimate of the external wrench.

    Attributes:
        period: Duration of one call of :meth:`follow`, seconds.

    Raises:
        Missing: If franky is not installed.
    """

    def __init__(self, host: str, *, tool: float = TOOL, wrench: Callable[[], Vector] | None = None) -> None:
        with needing("arms of the type FR3", "fr3", ROBOT):
            import franky
        self._franky, self._wrench, self.period = franky, wrench, _PERIOD
        self._tool = np.eye(4)
        self._tool[2, 3] = tool
        spec = mujoco.MjSpec()
        add_arm(spec).add_site(name=TOOL_SITE, pos=[0, 0, tool])
        self._model = spec.compile()
        self._posed, self._solver = mujoco.MjData(self._model), InverseKinematics(self._model)
        self._robot: Any = franky.Robot(
            host, relative_dynamics_factor=_SPEED, realtime_config=franky.RealtimeConfig.Ignore
        )
        self._robot.set_collision_behavior(_COLLISION / 2, _COLLISION)
        self._tracker: Any = None
        self._turn = self._pose()[:3, :3]
        self._stiffness, self._velocity = 0.0, np.zeros(3)

    @property
    def facts(self) -> Mapping[str, str]:
        """The library and the source of forces."""
        source = "robot's estimate" if self._wrench is None else "reader"
        return {"driver": f"franky-control {version('franky-control')}", "wrench": source}

    @property
    def time(self) -> float:
        """Seconds of a monotonic clock."""
        return time.monotonic()

    def home(self) -> None:
        """Go to the homing pose."""
        self._go(HOME)

    def reach(self, position: Vector, axis: Vector) -> None:
        """Go to a pose through joint space.

        Raises:
            PlantFault: If there is no solution within the limits of Panda and FR3.
        """
        angles = self._solver.solve(np.asarray(position, dtype=np.float64), axis)
        if angles is None or not ((angles > _LOWER) & (angles < _UPPER)).all():
            raise PlantFault(f"the arm cannot reach {np.round(position, 3).tolist()} (metres from its base)")
        self._go(angles)
        self._posed.qpos[:JOINTS] = angles
        mujoco.mj_kinematics(self._model, self._posed)
        self._turn = self._posed.site(TOOL_SITE).xmat.reshape(3, 3).copy()

    def follow(self, position: Vector, velocity: Vector, *, stiffness: float) -> None:
        """Follow a moving point for one period."""
        franky = self._franky
        if self._tracker is None:
            self._tracker = franky.CartesianImpedanceTracker(
                self._robot,
                translational_stiffness=stiffness,
                rotational_stiffness=_TURN_STIFFNESS,
                gains_time_constant=_GAINS_SECONDS,
                period=_PERIOD,
            )
            self._tracker.tick()  # the first one does not wait
            self._stiffness, self._velocity = stiffness, np.zeros(3)
        if stiffness != self._stiffness:
            self._tracker.set_gains(translational_stiffness=stiffness)
            self._stiffness = stiffness
        # The library holds a target until the next one comes: the middle of the period is right on average.
        tool = np.eye(4)
        tool[:3, :3], tool[:3, 3] = self._turn, position + 0.5 * _PERIOD * velocity
        target = tool @ np.linalg.inv(self._tool) @ np.asarray(self._robot.state.F_T_EE.matrix)
        # Without acceleration the hand overshoots by 13 mm at the end of a descent, with it by 5 mm.
        acceleration = (np.asarray(velocity) - self._velocity) / _PERIOD
        self._velocity = np.array(velocity)
        self._tracker.set_target(
            franky.Affine(target),
            franky.Twist(self._velocity, np.zeros(3)),
            franky.TwistAcceleration(acceleration, np.zeros(3)),
        )
        if self._tracker.tick() is None:
            raise PlantFault(f"the robot ended the motion: {self._why()}")

    def position(self) -> Vector:
        """Position of the tool, metres."""
        return np.asarray(self._pose()[:3, 3])

    def force(self) -> Vector:
        """Force on the hand, newtons, in the frame of the base.

        The robot's estimate is of the force on the environment, hence the sign. Its mean over a period is not known:
        the robot filters it.
        """
        if self._wrench is None:
            return -np.asarray(self._robot.state.O_F_ext_hat_K, dtype=np.float64).ravel()[:3]
        return np.asarray(self._pose()[:3, :3] @ self._wrench())

    def stop(self) -> None:
        """Abort every motion; the robot brakes by itself."""
        self._robot.stop()

    def _go(self, angles: NDArray[np.float64]) -> None:
        tracker, self._tracker = self._tracker, None
        if tracker is not None and self._robot.is_in_control:
            tracker.stop()
        else:
            with suppress(self._franky.ControlException):  # said when it came; a new motion would only repeat it
                self._robot.join_motion(_LONGEST_JOIN)
        if self._robot.has_errors and not self._robot.recover_from_errors():
            raise PlantFault(f"the robot cannot recover from its error: {self._why()}")
        self._robot.move(self._franky.JointMotion(angles.tolist()))

    def _why(self) -> str:
        """The library's reason for the end of the motion."""
        try:
            self._robot.join_motion(_LONGEST_JOIN)
        except self._franky.ControlException as error:
            return str(error)
        return "no reason given"

    def _pose(self) -> NDArray[np.float64]:
        """Pose of the tool in the frame of the base."""
        state = self._robot.state
        flange = np.asarray(state.O_T_EE.matrix) @ np.linalg.inv(np.asarray(state.F_T_EE.matrix))
        return np.asarray(flange @ self._tool)
