"""The joints of a compiled scene: reads, sets and pushes them, independent of an arm."""

from __future__ import annotations

import copy
from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.box import Configuration, bits
from lockprobe.foundation.errors import PlantFault
from lockprobe_robot.box_model.bolts import LIFT
from lockprobe_robot.box_model.gates import STROKE, GateLiteral
from lockprobe_robot.box_model.scene import LockboxScene

RESTING = 0.08
"""Largest distance of a resting joint from an end, as a fraction of its travel."""

_ARRIVED = 0.02
_HELD_SPEED, _HELD_STEPS = 0.02, 15
_QUIET_SPEED, _QUIET_STEPS = 0.004, 5
_PUSH_SECONDS, _SETTLE_SECONDS = 0.6, 1.0
_FROZEN = 0.005


class _Bolt:
    """A bolt or a lifter: its address in the state, and its position in each configuration."""

    def __init__(self, model: mujoco.MjModel, name: str, literals: Sequence[GateLiteral], out: float) -> None:
        joint = model.joint(name)
        self.address, self.dof = int(joint.qposadr[0]), int(joint.dofadr[0])
        self._literals, self._out = literals, out

    def position(self, configuration: Configuration) -> float:
        """Its position, metres: retracted if one of its literals holds."""
        return self._out if any(configuration[joint] == wanted for joint, wanted in self._literals) else 0.0


class Mechanism:
    """The joints of a lockbox in a model that may hold more than the lockbox.

    Args:
        model: The compiled model.
        data: Its state.
        scene: The scene that was compiled.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, scene: LockboxScene) -> None:
        self._model, self._data, self._scene = model, data, scene
        mounted_joints = scene.panel.mounted_joints
        joints = [model.joint(f"joint-{i}") for i in range(len(mounted_joints))]
        self._ids = np.array([joint.id for joint in joints])
        self._addresses = np.array([int(joint.qposadr[0]) for joint in joints])
        self._dofs = np.array([int(joint.dofadr[0]) for joint in joints])
        self._travel = np.array([mounted.travel for mounted in mounted_joints])
        self._arm = np.array([mounted.reach or 1.0 for mounted in mounted_joints])
        self._bolts = self._find_bolts()
        self._all_dofs = np.array([*self._dofs, *(bolt.dof for bolt in self._bolts)])
        # Speeds are compared at handles, in metres per second.
        self._scale = np.concatenate([self._arm, np.ones(len(self._bolts))])
        self._ranges: tuple[bool, ...] | None = None

    def fractions(self) -> NDArray[np.float64]:
        """How far each joint is from position 0, as a fraction of its travel, in panel order."""
        fractions: NDArray[np.float64] = self._data.qpos[self._addresses] / self._travel
        return fractions

    def configuration(self) -> Configuration:
        """The configuration: for each joint the nearer end of its travel."""
        return tuple(bool(fraction > 0.5) for fraction in self.fractions())

    def resting(self) -> bool:
        """Whether every joint is at an end of its travel, within a tolerance."""
        fractions = self.fractions()
        return bool((np.minimum(np.abs(fractions), np.abs(1 - fractions)) <= RESTING).all())

    def configuration_after(self, joint: int, before: Configuration) -> Configuration:
        """The configuration after an attempt.

        Args:
            joint: The attempted joint, by index in panel order.
            before: The configuration before the attempt.

        Raises:
            PlantFault: If a joint is between its ends, or a joint moved that was not attempted.
        """
        if not self.resting():
            where = ", ".join(f"{fraction:.2f}" for fraction in self.fractions())
            raise PlantFault(
                f"joint {joint} was attempted in {bits(before)} and the joints now stand at {where} of their travel"
            )
        after = self.configuration()
        if any(was != now for i, (was, now) in enumerate(zip(before, after, strict=True)) if i != joint):
            raise PlantFault(f"another joint moved with joint {joint}: {bits(before)} became {bits(after)}")
        return after

    def set_configuration(self, configuration: Configuration) -> None:
        """Put every joint at an end of its travel, at rest, and every bolt at the matching position."""
        data = self._data
        data.qpos[self._addresses] = np.where(configuration, self._travel, 0.0)
        for bolt in self._bolts:
            data.qpos[bolt.address] = bolt.position(configuration)
        data.qvel[self._all_dofs] = 0
        self._ranges = None
        self._switch_ranges()
        mujoco.mj_forward(self._model, data)

    def posed(self, configuration: Configuration) -> mujoco.MjData:
        """A copy of the state in which every joint is in the given configuration; nothing else differs.

        Bolts, which no camera sees, stay where they are.
        """
        copied = copy.copy(self._data)
        elsewhere = np.array(configuration) != np.array(self.configuration())
        ends = np.where(configuration, self._travel, 0.0)
        copied.qpos[self._addresses[elsewhere]] = ends[elsewhere]
        return copied

    def step(self) -> None:
        """One step of the simulation."""
        self.before_step()
        mujoco.mj_step(self._model, self._data)

    def before_step(self) -> None:
        """Call before every simulation step: switches the joint ranges of an ideal mechanism."""
        if self._scene.ideal:
            self._switch_ranges()

    def push(self, joint: int, newtons: float = 30.0) -> bool:
        """Push a handle towards its other end, then let everything come to rest.

        Args:
            joint: The joint, by index in panel order.
            newtons: Force at the handle. The push ends when the joint arrives or is blocked, after at most 0.6 s.

        Returns:
            Whether the joint is now nearer to the other end.
        """
        data, dof = self._data, self._dofs[joint]
        before = self.configuration()[joint]
        data.qfrc_applied[dof] = newtons * self._arm[joint] * (-1 if before else 1)
        held = 0
        for _ in range(self._steps(_PUSH_SECONDS)):
            self.step()
            fraction = float(data.qpos[self._addresses[joint]]) / self._travel[joint]
            slow = abs(float(data.qvel[dof])) * self._arm[joint] < _HELD_SPEED
            held = held + 1 if slow else 0
            if held >= _HELD_STEPS or (slow and abs(fraction - (not before)) < _ARRIVED):
                break
        data.qfrc_applied[dof] = 0
        self.settle()
        return self.configuration()[joint] != before

    def settle(self) -> None:
        """Step until nothing moves, at most a second."""
        quiet = 0
        for _ in range(self._steps(_SETTLE_SECONDS)):
            self.step()
            fast = np.abs(self._data.qvel[self._all_dofs] * self._scale).max() > _QUIET_SPEED
            quiet = 0 if fast else quiet + 1
            if quiet >= _QUIET_STEPS:
                return

    def _steps(self, seconds: float) -> int:
        return round(seconds / float(self._model.opt.timestep))

    def _find_bolts(self) -> list[_Bolt]:
        if self._scene.ideal:
            return []
        bolts = []
        for number, gate in enumerate(self._scene.gates):
            bolts.append(_Bolt(self._model, f"bolt-{number}", gate.literals, STROKE))
            if len(gate.literals) > 1:
                for index, literal in enumerate(gate.literals):
                    bolts.append(_Bolt(self._model, f"lifter-{number}-{index}", (literal,), LIFT))
        return bolts

    def _switch_ranges(self) -> None:
        """Free the joints that may move, and hold the others where they rest."""
        if not self._scene.ideal:
            return
        configuration = self.configuration()
        box = self._scene.box
        fractions = self.fractions()
        free = tuple(
            box.may_move(configuration, joint) or RESTING < fraction < 1 - RESTING
            for joint, fraction in enumerate(fractions)
        )
        if free == self._ranges:
            return
        self._ranges = free
        low = np.where(np.array(free) | ~np.array(configuration), 0.0, self._travel * (1 - _FROZEN))
        high = np.where(np.array(free) | np.array(configuration), self._travel, self._travel * _FROZEN)
        self._model.jnt_range[self._ids] = np.column_stack([low, high])
