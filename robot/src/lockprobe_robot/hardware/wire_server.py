"""A process that simulates the robot: our box and arm in MuJoCo behind Franka's network protocol (franky-sim).

The only importer of ``franky_sim``. The client library connects over loopback as it does to a robot. Two channels are
separate, as on a real rig: the force sensor's readings (shared memory) and the truth about the joints (a pipe).
"""

from __future__ import annotations

import multiprocessing
import time
from collections import deque
from dataclasses import dataclass
from importlib.metadata import version
from multiprocessing.connection import Connection
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.box import Configuration, Lockbox
from lockprobe.foundation.errors import PlantFault, needing
from lockprobe.foundation.plugins import ROBOT
from lockprobe_robot.arm.panda import JOINTS
from lockprobe_robot.hardware.wire_scene import WireScene
from lockprobe_robot.hardware.wrench import WrenchReading

__all__ = ["SimulatedRobot", "WireFigures"]

_AVERAGED = 20
"""Ticks over which the sensor averages, as the period of the guarded move."""

_REEL_EVERY, _REEL = 1 / 25, 3000
"""Seconds between two poses that are kept for a film, and the most that are kept."""

_START_SECONDS = 60.0
_ANSWER_SECONDS = 20.0
_LATE = 0.002
"""A tick of the simulated robot that takes longer than this counts as late, seconds."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WireFigures:
    """Timing statistics of the simulated robot.

    Attributes:
        ticks: Number of ticks of 1 ms so far.
        late: Number of ticks that took more than 2 ms.
    """

    ticks: int
    late: int


class SimulatedRobot:
    """The process that simulates the robot, with a reader of its force sensor. Use it as a context manager.

    Args:
        box: The box.
        labels: Labels of its joints, in panel order.
        seed: Seed of the scene's appearance.

    Raises:
        Missing: If franky-sim is not installed.
        PlantFault: If it does not start.
    """

    def __init__(self, box: Lockbox, labels: tuple[str, ...], seed: int = 0) -> None:
        with needing("rehearsals over the wire", "wire", ROBOT):
            import franky_sim  # noqa: F401 - a missing package is said here, not in the process
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._force = context.Array("d", 4, lock=True)
        self.process = context.Process(target=_serve, args=(box, labels, seed, theirs, self._force), daemon=True)
        self.process.start()
        theirs.close()
        self.host = str(self._answer(_START_SECONDS))

    @property
    def version(self) -> str:
        """The simulator and its version."""
        return f"franky-sim {version('franky-sim')}"

    def read(self) -> WrenchReading:
        """The latest reading of the sensor at the flange."""
        with self._force.get_lock():
            values = self._force[:]
        return WrenchReading(force=np.array(values[:3]), age=max(0.0, time.monotonic() - values[3]))

    def configuration(self) -> Configuration:
        """The configuration once the joints rest.

        Raises:
            PlantFault: If a joint stays between its ends, or the process is gone.
        """
        return tuple(self._ask("configuration"))

    def put(self, configuration: Configuration) -> None:
        """Set the configuration, as a person would between two attempts."""
        self._ask("put", configuration)

    def figures(self) -> WireFigures:
        """The timing statistics so far."""
        ticks, late = self._ask("figures")
        return WireFigures(ticks=ticks, late=late)

    def freeze(self, seconds: float) -> None:
        """Freeze the connection for some seconds: no command is read, no state is sent. To rehearse faults."""
        self._pipe.send(("freeze", seconds))

    def mute(self) -> None:
        """Silence the force sensor while the robot goes on. To rehearse faults."""
        self._pipe.send(("mute", None))

    def pose(self) -> list[float]:
        """All joint positions of the model (``qpos``), for :meth:`WireScene.pose`."""
        return list(self._ask("pose"))

    def reel(self) -> list[list[float]]:
        """The poses since the last call, 25 per second and the present one, up to two minutes."""
        return list(self._ask("reel"))

    def close(self) -> None:
        """End the process."""
        self._pipe.close()
        self.process.join(2)
        if self.process.is_alive():
            self.process.kill()
            self.process.join()

    def _ask(self, what: str, value: object = None) -> Any:
        try:
            self._pipe.send((what, value))
        except OSError:
            raise PlantFault("the simulated robot is gone") from None
        return self._answer(_ANSWER_SECONDS)

    def _answer(self, seconds: float) -> Any:
        try:
            if not self._pipe.poll(seconds):
                raise PlantFault(f"the simulated robot does not answer within {seconds:g} s")
            kind, value = self._pipe.recv()
        except (EOFError, OSError):
            raise PlantFault("the simulated robot is gone") from None
        if kind == "fault":
            raise PlantFault(str(value))
        return value


def _serve(box: Lockbox, labels: tuple[str, ...], seed: int, pipe: Connection, force: Any) -> None:
    """The main loop of the process: 1 ms of physics, one packet, and pending requests."""
    from franky_sim import SimulationServer

    world = _World(box, labels, seed)
    with world.simulator as simulator, SimulationServer(simulator) as server:
        pipe.send(("host", server.robot_servers[0].hostname))
        ticks = late = 0
        while True:
            began = time.monotonic()
            server.run_once()
            world.sense(force)
            ticks += 1
            late += time.monotonic() - began > _LATE
            try:
                if pipe.poll():
                    what, value = pipe.recv()
                    _execute(world, pipe, what, value, (ticks, late))
            except (EOFError, OSError):
                return


def _execute(world: _World, pipe: Connection, what: str, value: Any, figures: tuple[int, int]) -> None:
    if what == "freeze":
        time.sleep(value)
    elif what == "mute":
        world.mute = True
    elif what in ("pose", "reel"):
        pipe.send((what, world.pose() if what == "pose" else world.reel()))
    elif what == "figures":
        pipe.send((what, figures))
    elif what == "put":
        world.mechanism.set_configuration(value)
        pipe.send((what, None))
    elif world.mechanism.resting():
        pipe.send((what, world.mechanism.configuration()))
    else:
        fractions = ", ".join(f"{fraction:.2f}" for fraction in world.mechanism.fractions())
        pipe.send(("fault", f"a joint stays between its ends: the joints stand at {fractions} of their travel"))


class _World:
    """The scene with a simulator for franky-sim, a force-torque sensor at the flange, and recent poses."""

    def __init__(self, box: Lockbox, labels: tuple[str, ...], seed: int) -> None:
        scene = WireScene(box, labels, seed)
        self.mechanism, self._data = scene.mechanism, scene.data
        self.simulator = _simulator(scene)
        sensor = int(scene.model.sensor("force").adr[0])
        self._reading = scene.data.sensordata[sensor : sensor + 3]
        self._last = deque[NDArray[np.float64]](maxlen=_AVERAGED)
        self._reel, self._next = deque[list[float]](maxlen=_REEL), 0.0
        self.mute = False

    def sense(self, force: Any) -> None:
        """Write the time and the force on the hand in the frame of the flange, low-pass filtered as in a sensor."""
        if self._data.time >= self._next:
            self._next += _REEL_EVERY
            self._reel.append(self.pose())
        self._last.append(-self._reading.copy())
        if self.mute:
            return
        with force.get_lock():
            force[:3], force[3] = np.mean(self._last, axis=0), time.monotonic()

    def pose(self) -> list[float]:
        """All joint positions of the model."""
        return [float(number) for number in self._data.qpos]

    def reel(self) -> list[list[float]]:
        """All joint positions, 25 times a second since the last call."""
        rolled = [*self._reel, self.pose()]
        self._reel.clear()
        return rolled


def _simulator(scene: WireScene) -> Any:
    """A simulator of franky-sim whose robot is the arm of a scene."""
    from franky_sim import BaseRobot, BaseSimulator, RobotParameters
    from franky_sim.base_simulator import InnerRobotState

    model, data, joints = scene.model, scene.data, scene.arm_addresses
    dofs = [int(model.joint(f"arm-{number}").dofadr[0]) for number in range(1, JOINTS + 1)]

    class OurRobot(BaseRobot):  # type: ignore[misc] # the library has no types
        def __init__(self) -> None:
            # Gravity is compensated in the model. The library's frame of the hand is kept.
            super().__init__(robot_parameters=RobotParameters(gravity=(0.0, 0.0, 0.0)), has_gripper=False)
            self._torques = np.zeros(JOINTS)

        def _get_state(self) -> Any:
            return InnerRobotState(
                q=tuple(map(float, data.qpos[joints])),
                dq=tuple(map(float, data.qvel[dofs])),
                tau_j=tuple(map(float, self._torques)),
            )

        def _torque_control(self, torques: Any) -> None:
            self._torques = np.asarray(torques, dtype=np.float64)
            data.ctrl[:JOINTS] = self._torques

        def set_hand_goal(self, width: float, max_velocity: float, max_force: float) -> None:
            """There is no gripper."""

        def _get_hand_width(self) -> float:
            return 0.0

    class OurSimulator(BaseSimulator):  # type: ignore[misc]
        def __init__(self) -> None:
            super().__init__()
            self._robot = OurRobot()

        def _get_robots(self) -> list[Any]:
            return [self._robot]

        def _step(self) -> None:
            mujoco.mj_step(model, data)

    return OurSimulator()
