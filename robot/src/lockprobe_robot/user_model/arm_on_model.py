"""Puts the arm before a user's model: where its base stands, the paths of handles, and what is out of its reach."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.box import Lockbox
from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.plants.catalogue import FilmHook
from lockprobe.trial.record import Fact
from lockprobe_robot.arm.guarded_move import GuardedMove, HandlePath
from lockprobe_robot.arm.hand import TOOL, add_hand
from lockprobe_robot.arm.inverse_kinematics import InverseKinematics
from lockprobe_robot.arm.panda import add_panda
from lockprobe_robot.arm.protocol import Vector
from lockprobe_robot.arm.simulated_arm import SimulatedArm
from lockprobe_robot.filming import FILM_CAMERA, Filming, add_film_camera
from lockprobe_robot.user_model.compiled_model import compile_model
from lockprobe_robot.user_model.mjcf_file import MjcfModel
from lockprobe_robot.user_model.model_joints import ModelJoints

__all__ = ["BASE", "ArmOnModel", "Reach", "handle_path"]

BASE = "arm"
"""Site of a user's model where the base of the arm stands: x forwards, z up."""

_AHEAD, _ABOVE = 0.48, 0.2
"""Where the handles are from a base without a site, metres: as on the twin's own board."""

TIMESTEP = 0.002
"""The longest time step with which the arm is controlled, seconds."""

_POINTS = 33
_MOVES = 1e-6
_SHORT = 0.02
"""Share of its travel by which a handle may be short of an end."""

_MIDDLES = ((0.5, 0.25), (0.45, 0.45), (0.5, 0.6), (0.35, 0.3))
"""Points in the middle of the reach: metres from the base along the ground, and above it."""

_ACCURACY = 0.005
"""Of a distance out of reach, metres."""


def _base_of(bare: ModelJoints, panel: NDArray[np.float64], middle: Vector) -> NDArray[np.float64]:
    """The pose of the arm's base in the world, shape (4, 4): that of the site, or before the middle of the handles.

    Args:
        bare: The joints in the model without the arm.
        panel: Pose of the board in the world, shape (4, 4).
        middle: Middle of the handles in the world, metres.
    """
    model, data, base = bare.model, bare.posed(bare.configuration()), np.eye(4)
    mujoco.mj_kinematics(model, data)
    if (site := mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, BASE)) >= 0:
        base[:3, :3], base[:3, 3] = data.site_xmat[site].reshape(3, 3), data.site_xpos[site]
        return base
    ahead = panel[:3, 1] if abs(panel[2, 1]) < abs(panel[2, 2]) else -panel[:3, 2]
    ahead = np.array([*ahead[:2], 0.0]) / np.linalg.norm(ahead[:2])
    base[:3, :3] = np.array([ahead, np.cross([0, 0, 1], ahead), [0, 0, 1]]).T
    base[:3, 3] = middle - _AHEAD * ahead - [0, 0, _ABOVE]
    return base


def _add_arm(spec: mujoco.MjSpec, base: NDArray[np.float64]) -> None:
    """Add the arm, its hand and the camera for films to a parsed model, behind all that is there.

    Args:
        spec: The user's model; it is changed.
        base: Pose of the arm's base in the world, shape (4, 4).
    """
    arm = mujoco.MjSpec()
    arm.compiler.degree = False
    add_hand(arm, add_panda(arm))
    turn = np.zeros(4)
    mujoco.mju_mat2Quat(turn, np.ascontiguousarray(base[:3, :3]).ravel())
    spec.attach(arm, frame=spec.worldbody.add_frame(pos=base[:3, 3], quat=turn), prefix="")
    if spec.camera(FILM_CAMERA) is None:
        add_film_camera(spec, base)


class ArmOnModel:
    """The arm in a user's model, standing at home between attempts.

    Args:
        file: The model's file.
        bare: The joints in the model without the arm, in the initial configuration.
        box: The box.
        panel: Pose of the board in the world, shape (4, 4).
        film: Called 25 times per simulated second with the model and its state, which it must not change.

    Attributes:
        joints: The joints in the model with the arm.
        base: Pose of the arm's base in the world, shape (4, 4).

    Raises:
        BadFile: If a handle is out of reach, a joint has no site at its handle, or the time step is too long.
    """

    def __init__(
        self,
        file: MjcfModel,
        bare: ModelJoints,
        box: Lockbox,
        panel: NDArray[np.float64],
        film: FilmHook | None = None,
    ) -> None:
        if bare.model.opt.timestep > TIMESTEP:
            step = f"a time step of {bare.model.opt.timestep:g} s, expected at most {TIMESTEP:g} s with an arm"
            raise BadFile(file.path, step)
        self._axis, self._move = -panel[:3, 2], GuardedMove()
        try:
            paths = [handle_path(bare, name, joint, False, self._axis) for joint, name in enumerate(box.names)]
        except BadValue as error:
            raise BadFile(file.path, str(error)) from None
        self.base = _base_of(bare, panel, np.mean([path.points.mean(0) for path in paths], axis=0))
        self.joints = bare.recompiled(compile_model(file, lambda spec: _add_arm(spec, self.base)))
        self._names = box.names
        model, data = self.joints.model, self.joints.data
        self._arm = SimulatedArm(model, data, rng=np.random.default_rng(0), after_step=Filming(film, model, data))
        self.joints.share_with(self._arm)
        self._refuse_out_of_reach(file, paths)

    @property
    def place(self) -> str:
        """Where its base stands in the world, metres, as text."""
        return _metres(self.base[:3, 3])

    def attempt(self, joint: int, position: bool) -> Mapping[str, Fact]:
        """Drag a handle to its other end; what the arm sensed.

        The hand leaves a handle that rests by friction alone some millimetres short of an end. Such a handle is pushed
        to the end, as a person would.

        Args:
            joint: By index in panel order.
            position: The joint's present position.

        Raises:
            PlantFault: If the arm is held, or the simulation becomes unstable.
        """
        touch = self._move.attempt(self._arm, handle_path(self.joints, self._names[joint], joint, position, self._axis))
        self.joints.settle()
        nearer = self.joints.configuration()[joint]
        if abs(self.joints.fractions()[joint] - nearer) <= _SHORT:
            return touch.as_facts()
        self.joints.push(joint, nearer)
        return {**touch.as_facts(), "nudged": True}

    def _refuse_out_of_reach(self, file: MjcfModel, paths: Sequence[HandlePath]) -> None:
        turn, place = self.base[:3, :3], self.base[:3, 3]
        reach, far = Reach(self._axis @ turn), {}
        for name, path in zip(self._names, paths, strict=True):
            ends = [end - up * path.axis for end in path.points[[0, -1]] for up in (0.0, self._move.clearance)]
            if distance := max(reach.short_of((end - place) @ turn) for end in ends):
                far[name] = f"{distance:.2f} m out of reach" if distance < math.inf else "it cannot point that way"
        if far:
            each = ", ".join(f"{name} ({why})" for name, why in far.items())
            where = f"its base stands at {self.place} m; a site {BASE!r} in the model puts it elsewhere"
            raise BadFile(file.path, f"the arm does not reach {each}: {where}")


def _metres(point: Vector) -> str:
    return " ".join(f"{x:.3f}" for x in point + 0.0)


def handle_path(joints: ModelJoints, name: str, joint: int, position: bool, axis: Vector) -> HandlePath:
    """The path of a handle in the world, with the other joints where they are.

    Args:
        joints: The joints in the model.
        name: The joint, whose site is in the middle of its handle's top.
        joint: Its index in panel order.
        position: The position at which the path starts.
        axis: Direction in which the hand points, a unit vector.

    Raises:
        BadValue: If there is no such site, or it does not move with the joint.
    """
    model, data = joints.model, joints.posed(joints.configuration())
    if (site := mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, name)) < 0:
        raise BadValue(f"joint {name!r} of the model", "no site of its name", "one in the middle of its handle's top")
    points = []
    for fraction in np.linspace(float(position), float(not position), _POINTS):
        joints.pose(data, joint, float(fraction))
        mujoco.mj_kinematics(model, data)
        points.append(data.site_xpos[site].copy())
    if np.linalg.norm(points[1] - points[0]) < _MOVES:
        raise BadValue(f"site {name!r} of the model", "a site that does not move with its joint", "one on its handle")
    return HandlePath(points=np.array(points), axis=axis)


class Reach:
    """The points that the tool reaches while it points in one direction, in the frame of the arm's base.

    Args:
        axis: The direction, a unit vector.
    """

    def __init__(self, axis: Vector) -> None:
        spec = mujoco.MjSpec()
        add_panda(spec).add_site(name="tool", pos=[0, 0, TOOL])
        self._solver, self._axis = InverseKinematics(spec.compile()), axis

    def has(self, point: Vector) -> bool:
        """Whether the tool reaches a point, metres."""
        return self._solver.solve(point, self._axis) is not None

    def short_of(self, point: Vector) -> float:
        """How far a point would have to be moved towards the middle of the reach, metres.

        Returns:
            0 for a point that is reached; infinity if no middle is reached in this direction.
        """
        if self.has(point):
            return 0.0
        around = math.atan2(point[1], point[0])
        middles = [np.array([out * math.cos(around), out * math.sin(around), up]) for out, up in _MIDDLES]
        middle = next((middle for middle in middles if self.has(middle)), None)
        if middle is None:
            return math.inf
        way = middle - point
        reached, missed = 1.0, 0.0
        while (reached - missed) * np.linalg.norm(way) > _ACCURACY:
            half = (reached + missed) / 2
            reached, missed = (half, missed) if self.has(point + half * way) else (reached, half)
        return reached * float(np.linalg.norm(way))
