"""The Panda and its hand in MuJoCo, as an :class:`lockprobe_robot.arm.protocol.StoppableArm`.

It follows points by Cartesian impedance control: joint torques that make the tool behave like springs and dampers, at
the rate of the simulation. They compensate gravity and Coriolis forces with the dynamics model. Free motions follow
joint angles by computed-torque control. The null space (the one motion of seven joints that does not move the tool)
stays near a posture.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import PlantFault
from lockprobe_robot.arm.inverse_kinematics import InverseKinematics
from lockprobe_robot.arm.model import ACCELERATION_LIMITS, HOME, JOINTS, VELOCITY_LIMITS
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

_STEPS_PER_PERIOD = 5
_SPEED_SHARE, _ACCELERATION_SHARE = 0.85, 0.6
_ARRIVED = 0.02


class SimulatedArm:
    """The simulated arm. Every command steps the simulation of the whole scene.

    Args:
        force_noise: Standard deviation of each component of a force reading, newtons.
        after_step: Called after every step of the simulation.

    Attributes:
        period: Seconds that one call of :meth:`follow` takes.
        rng: Random stream of the noise. The number of draws does not depend on the noise.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        *,
        force_noise: float = 0.0,
        rng: np.random.Generator,
        after_step: Callable[[], None] = lambda: None,
    ) -> None:
        self._model, self._data = model, data
        first, address = int(model.joint("arm-1").dofadr[0]), int(model.joint("arm-1").qposadr[0])
        self._dofs = slice(first, first + JOINTS)
        self._site, motor = model.site("tool").id, model.actuator("arm-1").id
        self._joints: NDArray[np.float64] = data.qpos[address : address + JOINTS]
        self._speeds: NDArray[np.float64] = data.qvel[self._dofs]
        self._bias, self._passive = data.qfrc_bias[self._dofs], data.qfrc_passive[self._dofs]
        self._ctrl, self._limits = data.ctrl[motor : motor + JOINTS], model.actuator_ctrlrange[motor : motor + JOINTS]
        self._tool: Vector = data.site_xpos[self._site]
        self._tool_turn: NDArray[np.float64] = data.site_xmat[self._site].reshape(3, 3)
        self._jacobian = np.zeros((6, model.nv))
        self._linear, self._angular = self._jacobian[:3], self._jacobian[3:]
        self._j = self._jacobian[:, self._dofs]
        self._full, self._product = np.zeros(model.nv), np.zeros(model.nv)
        self._rows, self._weighted = np.zeros((6, model.nv)), np.zeros((6, model.nv))
        self._null, self._age = np.zeros(JOINTS), 0
        self._inertia: NDArray[np.float64] = np.eye(6)
        self._tension = np.zeros(6)
        self._solver = InverseKinematics(model)
        self._noise, self.rng = force_noise, rng
        self._after_step = after_step
        sensor = int(model.sensor("force").adr[0])
        self._reading = data.sensordata[sensor : sensor + 3]
        self._wrench = data.site_xmat[model.site("wrench").id].reshape(3, 3)
        self._force, self._velocity = np.zeros(3), np.zeros(3)
        self._turn = np.eye(3)
        self._posture = HOME.copy()
        self._dt = float(model.opt.timestep)
        self.period = _STEPS_PER_PERIOD * self._dt

    @property
    def time(self) -> float:
        """Simulated seconds."""
        return float(self._data.time)

    def stand(self) -> None:
        """Set the arm to its homing pose instantly, at rest."""
        self._joints[:] = HOME
        self._speeds[:] = 0
        mujoco.mj_forward(self._model, self._data)

    def home(self) -> None:
        """Go to the homing pose."""
        self._go(HOME)

    def reach(self, position: Vector, axis: Vector) -> None:
        """Go to a pose freely. :meth:`follow` then keeps the orientation of that pose."""
        angles = self._solver.solve(position, axis)
        if angles is None:
            raise PlantFault(f"the arm cannot reach {np.round(position, 3).tolist()} (metres from its base)")
        self._go(angles)
        self._turn = self._tool_turn.copy()
        self._posture, self._velocity = angles, np.zeros(3)

    def follow(self, position: Vector, velocity: Vector, *, stiffness: float) -> None:
        """Follow a moving point for one period."""
        point, stride = np.array(position), self._dt * velocity
        acceleration = (velocity - self._velocity) / self.period
        self._velocity = np.array(velocity)
        total = np.zeros(3)
        for _ in range(_STEPS_PER_PERIOD):
            self._pull(point, velocity, acceleration, stiffness)
            point += stride
            total += self._reading
        self._read(total / _STEPS_PER_PERIOD)

    def stop(self) -> None:
        """Forget the last command. Simulated time passes only in commands, so the arm already stands."""
        self._velocity = np.zeros(3)

    def wait(self) -> None:
        """Stand still in the homing pose for one period."""
        still = np.zeros(JOINTS)
        for _ in range(_STEPS_PER_PERIOD):
            self._track(HOME, still, still)

    def reaches(self, position: Vector, axis: Vector) -> bool:
        """Whether the tool can reach a position and point along an axis."""
        return self._solver.solve(position, axis) is not None

    def position(self) -> Vector:
        """Position of the tool, metres."""
        return self._tool.copy()

    def force(self) -> Vector:
        """The mean force over the last period, newtons."""
        return self._force

    def _go(self, angles: NDArray[np.float64]) -> None:
        """Move through joint space, somewhat slower than the published limits."""
        start = self._joints.copy()
        way = angles - start
        size = np.maximum(np.abs(way), 1e-9)
        fastest = float((_SPEED_SHARE * VELOCITY_LIMITS / size).min())
        most = float((_ACCELERATION_SHARE * ACCELERATION_LIMITS / size).min())
        for done, speed, acceleration in _profile(fastest, most, self._dt):
            self._track(start + done * way, speed * way, acceleration * way)
        self._read(self._reading)
        if np.abs(self._joints - angles).max() > _ARRIVED:
            raise PlantFault("something held the arm on its way")

    def _read(self, reading: NDArray[np.float64]) -> None:
        """Store a reading in the base's frame. The simulation senses the flange's force on the hand, hence the sign."""
        self._force = self._noise * self.rng.standard_normal(3) - self._wrench @ reading

    def _track(
        self, angles: NDArray[np.float64], speeds: NDArray[np.float64], accelerations: NDArray[np.float64]
    ) -> None:
        """Follow a joint motion for one step by computed-torque control."""
        mujoco.mj_step1(self._model, self._data)
        self._full[self._dofs] = (
            accelerations + _TRACK_STIFFNESS * (angles - self._joints) + _TRACK_DAMPING * (speeds - self._speeds)
        )
        mujoco.mj_mulM(self._model, self._data, self._product, self._full)
        self._age = 0
        self._step(self._product[self._dofs])

    def _pull(self, position: Vector, velocity: Vector, acceleration: Vector, stiffness: float) -> None:
        """Pull the tool for one step towards a moving point and the orientation that it keeps."""
        mujoco.mj_step1(self._model, self._data)
        mujoco.mj_jacSite(self._model, self._data, self._linear, self._angular, self._site)
        jacobian, speeds, pull = self._j, self._speeds, self._tension
        twist = jacobian @ speeds
        error = position - self._tool
        if (size := math.sqrt(error @ error)) > _LONGEST_ERROR:
            error *= _LONGEST_ERROR / size
        damping = 2 * _DAMPING_RATIO * math.sqrt(stiffness * _TOOL_MASS)
        pull[:3] = stiffness * error + damping * (velocity - twist[:3])
        off = (self._turn @ self._tool_turn.T).ravel()
        pull[3:] = 0.5 * _TURN_STIFFNESS * (off[_PLUS] - off[_MINUS]) - _TURN_DAMPING * twist[3:]
        if self._age == 0:  # null space and operational-space inertia change slowly
            self._null = np.linalg.svd(jacobian)[2][-1]
            self._rows[:, self._dofs] = jacobian
            mujoco.mj_solveM(self._model, self._data, self._weighted, self._rows)
            felt = self._weighted[:, self._dofs] @ jacobian.T + _REGULAR * np.eye(6)
            self._inertia = np.asarray(np.linalg.inv(felt), dtype=np.float64)
        self._age = (self._age + 1) % _REFRESH_EVERY
        pull += self._inertia[:, :3] @ acceleration
        keep = self._null @ (_POSTURE_STIFFNESS * (self._posture - self._joints) - _POSTURE_DAMPING * speeds)
        self._step(pull @ jacobian + keep * self._null)

    def _step(self, torques: NDArray[np.float64]) -> None:
        """Complete a step with torques, within the motors' limits, on top of those that hold the arm's weight."""
        torques = torques + self._bias - self._passive
        self._ctrl[:] = np.minimum(np.maximum(torques, self._limits[:, 0]), self._limits[:, 1])
        mujoco.mj_step2(self._model, self._data)
        self._after_step()


def _profile(speed: float, most: float, dt: float) -> Iterator[tuple[float, float, float]]:
    """A trapezoidal velocity profile from 0 to 1: share of the way, speed and acceleration after every time step."""
    speed = min(speed, most**0.5)
    ramp = speed / most
    seconds = 1 / speed + ramp
    for step in range(1, int(seconds / dt) + 3):
        time = step * dt
        left = seconds - time
        if left <= 0:
            yield 1.0, 0.0, 0.0
        elif time < ramp:
            yield 0.5 * most * time**2, most * time, most
        elif left < ramp:
            yield 1 - 0.5 * most * left**2, most * left, -most
        else:
            yield speed * (time - ramp / 2), speed, 0.0
