"""The Panda and its hand in MuJoCo, as an :class:`lockprobe_robot.arm.protocol.StoppableArm`."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import PlantFault
from lockprobe_robot.arm.force_control import ForceController
from lockprobe_robot.arm.inverse_kinematics import InverseKinematics
from lockprobe_robot.arm.model import ACCELERATION_LIMITS, HOME, JOINTS, VELOCITY_LIMITS
from lockprobe_robot.arm.protocol import Vector

_STEPS_PER_PERIOD = 5
_SPEED_SHARE, _ACCELERATION_SHARE = 0.85, 0.6
_ARRIVED = 0.02


class SimulatedArm:
    """The simulated arm. Every command steps the simulation of the whole scene.

    Args:
        model: A compiled scene with the arm and the hand.
        data: Its state.
        force_noise: Standard deviation of each component of a force reading, newtons.
        rng: Random stream of the noise until :meth:`use_stream`. The number of draws does not depend on the noise.
        after_step: Called after every step of the simulation.

    Attributes:
        period: Seconds that one call of :meth:`follow` takes.
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
        self._controller = ForceController(model, data)
        self._solver = InverseKinematics(model)
        self._noise, self._rng = force_noise, rng
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

    def use_stream(self, rng: np.random.Generator) -> None:
        """Draw the noise of forces from this stream from now on."""
        self._rng = rng

    def stand(self) -> None:
        """Set the arm to its homing pose instantly, at rest."""
        self._controller.joints[:] = HOME
        self._controller.speeds[:] = 0
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
        self._turn = self._controller.turn.copy()
        self._posture, self._velocity = angles, np.zeros(3)

    def follow(self, position: Vector, velocity: Vector, *, stiffness: float) -> None:
        """Follow a moving point for one period."""
        point = np.array(position)
        stride = self._dt * velocity
        acceleration = (velocity - self._velocity) / self.period
        self._velocity = np.array(velocity)
        total = np.zeros(3)
        for _ in range(_STEPS_PER_PERIOD):
            mujoco.mj_step1(self._model, self._data)
            self._controller.pull(point, self._turn, velocity, acceleration, stiffness=stiffness, posture=self._posture)
            self._finish_step()
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
            mujoco.mj_step1(self._model, self._data)
            self._controller.track(HOME, still, still)
            self._finish_step()

    def reaches(self, position: Vector, axis: Vector) -> bool:
        """Whether the tool can reach a position and point along an axis."""
        return self._solver.solve(position, axis) is not None

    def position(self) -> Vector:
        """Position of the tool, metres."""
        return self._controller.tool.copy()

    def force(self) -> Vector:
        """The mean force over the last period, newtons."""
        return self._force

    def _go(self, angles: NDArray[np.float64]) -> None:
        """Move through joint space, somewhat slower than the published limits."""
        start = self._controller.joints.copy()
        way = angles - start
        size = np.maximum(np.abs(way), 1e-9)
        fastest = float((_SPEED_SHARE * VELOCITY_LIMITS / size).min())
        most = float((_ACCELERATION_SHARE * ACCELERATION_LIMITS / size).min())
        for done, speed, acceleration in _profile(fastest, most, self._dt):
            mujoco.mj_step1(self._model, self._data)
            self._controller.track(start + done * way, speed * way, acceleration * way)
            self._finish_step()
        self._read(self._reading)
        if np.abs(self._controller.joints - angles).max() > _ARRIVED:
            raise PlantFault("something held the arm on its way")

    def _read(self, reading: NDArray[np.float64]) -> None:
        """Store a reading in the base's frame. The simulation senses the flange's force on the hand, hence the sign."""
        self._force = self._noise * self._rng.standard_normal(3) - self._wrench @ reading

    def _finish_step(self) -> None:
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
