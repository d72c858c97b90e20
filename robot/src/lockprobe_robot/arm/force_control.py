"""Cartesian impedance control of the arm: joint torques that make the tool behave like springs and dampers.

This is the inner loop, at the rate of the simulation. It compensates gravity and Coriolis forces with the dynamics
model. Free motions follow joint angles by computed-torque control. The null space (the one motion of seven joints that
does not move the tool) stays near a posture.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe_robot.arm.model import JOINTS
from lockprobe_robot.arm.protocol import Vector

_TURN_STIFFNESS = 120.0
_TURN_DAMPING = 15.0
_TOOL_MASS = 10.0
_DAMPING_RATIO = 0.9
_LONGEST_ERROR = 0.05
_POSTURE_STIFFNESS, _POSTURE_DAMPING = 30.0, 6.0
_TRACK_STIFFNESS, _TRACK_DAMPING = 900.0, 60.0
_REFRESH_EVERY = 10
_REGULAR = 1e-3

_PLUS, _MINUS = np.array([7, 2, 3]), np.array([5, 6, 1])
"""Entries of a flat 3 by 3 matrix whose differences are twice the vector of its skew part."""


class ForceController:
    """The impedance controller. It writes torques to ``data.ctrl``; call it between ``mj_step1`` and ``mj_step2``.

    Args:
        model: A compiled scene with the arm and the hand.
        data: Its state. The controller reads it and writes ``ctrl``.

    Attributes:
        joints: View of the joint angles, radians, shape (7,).
        speeds: View of the joint velocities, radians per second, shape (7,).
        tool: View of the tool's position, metres.
        turn: View of the tool's orientation, shape (3, 3).
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self._model, self._data = model, data
        first, address = int(model.joint("arm-1").dofadr[0]), int(model.joint("arm-1").qposadr[0])
        self._dofs = slice(first, first + JOINTS)
        self._site, motor = model.site("tool").id, model.actuator("arm-1").id
        self.joints: NDArray[np.float64] = data.qpos[address : address + JOINTS]
        self.speeds: NDArray[np.float64] = data.qvel[self._dofs]
        self._bias, self._passive = data.qfrc_bias[self._dofs], data.qfrc_passive[self._dofs]
        self._ctrl, self._limits = data.ctrl[motor : motor + JOINTS], model.actuator_ctrlrange[motor : motor + JOINTS]
        self.tool: Vector = data.site_xpos[self._site]
        self.turn: NDArray[np.float64] = data.site_xmat[self._site].reshape(3, 3)
        self._jacobian = np.zeros((6, model.nv))
        self._linear, self._angular = self._jacobian[:3], self._jacobian[3:]
        self._j = self._jacobian[:, self._dofs]
        self._full, self._product = np.zeros(model.nv), np.zeros(model.nv)
        self._rows, self._weighted = np.zeros((6, model.nv)), np.zeros((6, model.nv))
        self._null, self._age = np.zeros(JOINTS), 0
        self._inertia: NDArray[np.float64] = np.eye(6)
        self._pull = np.zeros(6)

    def track(
        self, angles: NDArray[np.float64], speeds: NDArray[np.float64], accelerations: NDArray[np.float64]
    ) -> None:
        """Follow a joint motion by computed-torque control: radians and seconds, shape (7,) each."""
        self._full[self._dofs] = (
            accelerations + _TRACK_STIFFNESS * (angles - self.joints) + _TRACK_DAMPING * (speeds - self.speeds)
        )
        mujoco.mj_mulM(self._model, self._data, self._product, self._full)
        self._write(self._product[self._dofs])
        self._age = 0

    def pull(
        self,
        position: Vector,
        turn: NDArray[np.float64],
        velocity: Vector,
        acceleration: Vector,
        *,
        stiffness: float,
        posture: NDArray[np.float64],
    ) -> None:
        """Pull the tool towards a pose by Cartesian impedance, with null-space posture control.

        Args:
            position: Metres.
            turn: Orientation, shape (3, 3).
            velocity: Velocity of the target point, metres per second.
            acceleration: Acceleration of the target point, metres per second squared.
            stiffness: Translational stiffness, newtons per metre.
            posture: Null-space posture: preferred joint angles, radians, shape (7,).
        """
        mujoco.mj_jacSite(self._model, self._data, self._linear, self._angular, self._site)
        jacobian, speeds, pull = self._j, self.speeds, self._pull
        twist = jacobian @ speeds
        error = position - self.tool
        if (size := math.sqrt(error @ error)) > _LONGEST_ERROR:
            error *= _LONGEST_ERROR / size
        damping = 2 * _DAMPING_RATIO * math.sqrt(stiffness * _TOOL_MASS)
        pull[:3] = stiffness * error + damping * (velocity - twist[:3])
        off = (turn @ self.turn.T).ravel()
        pull[3:] = 0.5 * _TURN_STIFFNESS * (off[_PLUS] - off[_MINUS]) - _TURN_DAMPING * twist[3:]
        if self._age == 0:  # null space and operational-space inertia change slowly
            self._null = np.linalg.svd(jacobian)[2][-1]
            self._rows[:, self._dofs] = jacobian
            mujoco.mj_solveM(self._model, self._data, self._weighted, self._rows)
            felt = self._weighted[:, self._dofs] @ jacobian.T + _REGULAR * np.eye(6)
            self._inertia = np.asarray(np.linalg.inv(felt), dtype=np.float64)
        self._age = (self._age + 1) % _REFRESH_EVERY
        pull += self._inertia[:, :3] @ acceleration
        null = self._null
        keep = null @ (_POSTURE_STIFFNESS * (posture - self.joints) - _POSTURE_DAMPING * speeds)
        self._write(pull @ jacobian + keep * null)

    def _write(self, torques: NDArray[np.float64]) -> None:
        torques = torques + self._bias - self._passive
        self._ctrl[:] = np.minimum(np.maximum(torques, self._limits[:, 0]), self._limits[:, 1])
