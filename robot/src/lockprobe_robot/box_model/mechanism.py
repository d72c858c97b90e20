"""The joints of a compiled scene with their bolts: set to a configuration, and pushed without an arm."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from lockprobe.boxes.box import Configuration
from lockprobe_robot.box_model.bolts import LIFT
from lockprobe_robot.box_model.gates import STROKE, GateLiteral
from lockprobe_robot.box_model.joints import Joints
from lockprobe_robot.box_model.scene import LockboxScene

_ARRIVED = 0.02
_HELD_SPEED, _HELD_STEPS = 0.02, 15
_PUSH_SECONDS = 0.6


class Mechanism(Joints):
    """The joints of a lockbox in a scene, which is compiled with everything that was added to it."""

    def __init__(self, scene: LockboxScene) -> None:
        model = scene.spec.compile()
        super().__init__(model, mujoco.MjData(model), scene.names)
        self._reach = np.array([mounted.reach or 1.0 for mounted in scene.panel.mounted_joints])
        # A bolt or lifter, and how far it is out where one of its literals holds.
        self._bolts: list[tuple[Any, tuple[GateLiteral, ...], float]] = []
        for number, gate in enumerate(scene.gates):
            self._bolts.append((model.joint(f"bolt-{number}"), gate.literals, STROKE))
            for index, literal in enumerate(gate.literals if len(gate.literals) > 1 else ()):
                self._bolts.append((model.joint(f"lifter-{number}-{index}"), (literal,), LIFT))
        self._all_dofs = np.array([*self._dofs, *(int(bolt.dofadr[0]) for bolt, _, _ in self._bolts)])
        self._quiet, self._scale = (0.004, 0.01), np.zeros(model.nv)
        # Speeds are compared at handles, in metres per second.
        self._scale[self._all_dofs] = np.concatenate([self._reach, np.ones(len(self._bolts))])

    def set_configuration(self, configuration: Configuration) -> None:
        """Put every joint at an end of its travel, at rest, and every bolt at the matching position."""
        data = self.data
        data.qpos[self._addresses] = self.ends(configuration)
        for bolt, literals, out in self._bolts:
            drawn = any(configuration[joint] == wanted for joint, wanted in literals)
            data.qpos[int(bolt.qposadr[0])] = out if drawn else 0.0
        data.qvel[self._all_dofs] = 0
        mujoco.mj_forward(self.model, data)

    def push(self, joint: int, newtons: float = 30.0) -> None:
        """Push a handle with a force until the joint arrives or is blocked, at most 0.6 s, and let all come to rest."""
        data, dof, reach = self.data, self._dofs[joint], self._reach[joint]
        before = self.configuration()[joint]
        data.qfrc_applied[dof] = newtons * reach * (-1 if before else 1)
        held = 0
        for _ in range(self._steps(_PUSH_SECONDS)):
            self.step()
            slow = abs(float(data.qvel[dof])) * reach < _HELD_SPEED
            held = held + 1 if slow else 0
            if held >= _HELD_STEPS or (slow and abs(self.fractions()[joint] - (not before)) < _ARRIVED):
                break
        data.qfrc_applied[dof] = 0
        self.settle()
