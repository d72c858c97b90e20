"""Inverse kinematics: joint angles that bring the tool to a position, by damped least squares.

The rotation of the hand about its axis is free, because a ring holds a round knob from any side.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe_robot.arm.model import JOINTS
from lockprobe_robot.arm.protocol import Vector

_STEPS = 200
_DAMPING = 1e-4
_LONGEST_STEP = 0.3
_MARGIN = 0.03
_POSTURE_GAIN = 0.05
_CLOSE = 2e-4
_TURN_WEIGHT = 0.3

_MIDDLE = np.array([0.0, 0.2, 0.0, -2.1, 0.0, 2.2, math.pi / 4])
"""A comfortable posture far from joint limits, radians."""


class InverseKinematics:
    """An inverse kinematics solver for a scene with the arm and a site ``tool``, of whose state it has its own."""

    def __init__(self, model: mujoco.MjModel) -> None:
        self._model, self._data = model, mujoco.MjData(model)
        joint = model.joint("arm-1")
        first, address = int(joint.dofadr[0]), int(joint.qposadr[0])
        self._q: NDArray[np.float64] = self._data.qpos[address : address + JOINTS]
        limits = model.jnt_range[joint.id : joint.id + JOINTS]
        self._lower, self._upper = limits[:, 0] + _MARGIN, limits[:, 1] - _MARGIN
        base = model.body("arm-link0").id
        mujoco.mj_kinematics(model, self._data)
        self._base, self._base_turn = self._data.xpos[base].copy(), self._data.xmat[base].reshape(3, 3).copy()
        self._site = model.site("tool").id
        self._tool = self._data.site_xpos[self._site]
        self._turn = self._data.site_xmat[self._site].reshape(3, 3)
        self._jacobian = np.zeros((6, model.nv))
        self._j = self._jacobian[:, first : first + JOINTS]

    def solve(self, position: Vector, axis: Vector) -> NDArray[np.float64] | None:
        """Joint angles for a position of the tool; None if the solver does not converge.

        The search starts from the middle posture turned towards the position. The rotation about the hand's axis is
        projected out of the task.
        The position is in the world, metres; the hand points along the axis, a unit vector. Angles are radians, shape
        (7,), within the joint limits by a margin, accurate to 0.2 mm and 0.05 degrees.
        """
        posture = _MIDDLE.copy()
        ahead, left, _ = self._base_turn.T @ (position - self._base)
        posture[0] = math.atan2(left, ahead)
        self._q[:] = posture
        gaps = np.empty(6)
        for _ in range(_STEPS):
            mujoco.mj_kinematics(self._model, self._data)
            mujoco.mj_comPos(self._model, self._data)
            gaps[:3] = position - self._tool
            gaps[3:] = np.cross(self._turn[:, 2], axis)
            inside = ((self._q >= self._lower) & (self._q <= self._upper)).all()
            if self._turn[:, 2] @ axis > 0 and np.abs(gaps).max() < _CLOSE and inside:
                return self._q.copy()
            mujoco.mj_jacSite(self._model, self._data, self._jacobian[:3], self._jacobian[3:], self._site)
            task = self._j.copy()
            task[3:] -= np.outer(axis, axis @ task[3:])
            task[3:] *= _TURN_WEIGHT
            wanted = gaps.copy()
            wanted[3:] *= _TURN_WEIGHT
            inverse = task.T @ np.linalg.inv(task @ task.T + _DAMPING * np.eye(6))
            rest = _POSTURE_GAIN * (posture - self._q)
            step = inverse @ (wanted - task @ rest) + rest
            if (size := float(np.abs(step).max())) > _LONGEST_STEP:
                step *= _LONGEST_STEP / size
            self._q[:] = np.clip(self._q + step, self._lower, self._upper)
        return None
