"""The joints of a user's model, pushed by generalised forces.

A push is newtons on a sliding joint, newton metres on a turning one. So a model needs no handles. A generalised force
is simpler than a hand: it neither presses on the board nor pulls at an edge. Like a hand it is slow: the force grows
only while the joint is slower than a target speed, because fast thin parts tunnel through each other in a simulation.
"""

from __future__ import annotations

import mujoco
import numpy as np

from lockprobe.boxes.box import Configuration, Lockbox, bits
from lockprobe.foundation.errors import BadValue, PlantFault
from lockprobe_robot.box_model.joints import Joints

INITIAL = "initial"
"""Keyframe in which the parts of the model stand when a trial begins; without it, the model's reference."""

_ARRIVED = 0.02
_QUIET_SPEED, _QUIET_SECONDS = 0.05, 0.02
_PUSH_SECONDS = 1.5
_TRAVEL_SECONDS, _GROWTH_SECONDS = 0.4, 0.2
"""A push takes a joint along its travel in the first time, and its force grows from 0 to the limit in the second."""

_KINDS = {"prismatic": (mujoco.mjtJoint.mjJNT_SLIDE, "slide"), "revolute": (mujoco.mjtJoint.mjJNT_HINGE, "hinge")}

_UNSTABLE = (
    mujoco.mjtWarning.mjWARN_BADQPOS,
    mujoco.mjtWarning.mjWARN_BADQVEL,
    mujoco.mjtWarning.mjWARN_BADQACC,
)


class ModelJoints(Joints):
    """The joints of a box in a user's model, found by their names.

    Args:
        force: Push on a sliding joint, newtons.
        torque: Push on a turning joint, newton metres.

    Raises:
        BadValue: If a joint is missing, of the wrong type or without a range, or if a part can move freely.
    """

    def __init__(self, model: mujoco.MjModel, box: Lockbox, *, force: float, torque: float) -> None:
        loose = np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE)
        if loose.size:
            raise BadValue("the model", f"a free joint {model.joint(loose[0]).name!r}", "only joints with a fixed way")
        for joint in box.joints:
            wanted, title = _KINDS[joint.kind]
            found = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, joint.name)
            if found < 0:
                there = ", ".join(repr(model.joint(i).name) for i in range(min(model.njnt, 40))) or "none"
                raise BadValue("joints of the model", there, f"one called {joint.name!r}, as in the box")
            what, (low, high) = f"joint {joint.name!r} of the model", model.jnt_range[found]
            if model.jnt_type[found] != wanted:
                raise BadValue(what, "another type", f'type="{title}", since it is {joint.kind}')
            if not model.jnt_limited[found] or not low < high:
                raise BadValue(what, "no range", "a limited range: position 0 to position 1")
        super().__init__(model, mujoco.MjData(model), box.names)
        self._strength = [force if joint.kind == "prismatic" else torque for joint in box.joints]
        self._quiet, self._scale = (_QUIET_SPEED, _QUIET_SECONDS), np.ones(model.nv)
        self._scale[self._dofs] = 1 / self._travel

    def start(self, initial: Configuration) -> None:
        """Set the model to the start of a trial, and let it come to rest.

        Raises:
            PlantFault: If it does not come to rest in the initial configuration of the box.
        """
        if mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_KEY, INITIAL) >= 0:
            mujoco.mj_resetDataKeyframe(self.model, self.data, self.model.key(INITIAL).id)
        else:
            mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[self._addresses] = self.ends(initial)
        self.settle()
        if not self.resting() or self.configuration() != initial:
            raise PlantFault(f"the model does not rest in the initial configuration {bits(initial)}: {self.where()}")

    def push(self, joint: int) -> None:
        """Push a joint towards its other end for at most 1.5 s, then let everything come to rest.

        Raises:
            PlantFault: If the simulation becomes unstable.
        """
        data, dof = self.data, self._dofs[joint]
        goal = not self.configuration()[joint]
        sign, growth = (1 if goal else -1), float(self.model.opt.timestep) / _GROWTH_SECONDS
        share = 0.0
        for _ in range(self._steps(_PUSH_SECONDS)):
            speed = sign * float(data.qvel[dof]) / self._travel[joint]
            share = min(max(share + growth * (1 - speed * _TRAVEL_SECONDS), 0.0), 1.0)
            data.qfrc_applied[dof] = sign * share * self._strength[joint]
            self.step()
            if abs(speed) < _QUIET_SPEED and abs(self.fractions()[joint] - goal) < _ARRIVED:
                break
        data.qfrc_applied[dof] = 0
        self.settle()

    def step(self) -> None:
        """One step of the simulation.

        Raises:
            PlantFault: If it becomes unstable.
        """
        try:
            super().step()
        except mujoco.FatalError as error:
            raise PlantFault(f"MuJoCo cannot simulate the model ({error})") from None
        if any(self.data.warning[kind].number for kind in _UNSTABLE):
            raise PlantFault("the simulation of the model became unstable: not a number, or a huge value")
