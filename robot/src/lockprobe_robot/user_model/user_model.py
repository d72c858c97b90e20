"""The plant ``twin?model=FILE``: a user's own MuJoCo model of a box, pushed by generalised forces."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.box import Configuration, Lockbox, bits
from lockprobe.foundation.errors import BadFile, BadValue, PlantFault
from lockprobe.trial.pictures.frame import Frame
from lockprobe.trial.record import Fact, Snapshot
from lockprobe_robot.rendering.plant_camera import PlantCamera
from lockprobe_robot.twin_settings import UserModelSettings
from lockprobe_robot.user_model.compiled_model import CAMERA, compile_model, without_stderr
from lockprobe_robot.user_model.label_overlay import draw_labels
from lockprobe_robot.user_model.mjcf_file import MjcfModel, read_model
from lockprobe_robot.user_model.model_joints import ModelJoints
from lockprobe_robot.user_model.rules_check import check_rules

PANEL = "panel"
"""Body that is the board: z out of it. Without it, heights in depth pictures are those of the world."""


def check_model(box: Lockbox, settings: UserModelSettings) -> int:
    """Read a model, and check it against the rules of a box by pushing.

    Returns:
        The number of configurations in which every joint was pushed.

    Raises:
        BadFile: If the model cannot be read, lacks a joint, or does not obey the rules.
    """
    with without_stderr():
        joints = _load(box, settings)[1]
    return check_rules(joints, box, Path(settings.model))


class UserModel:
    """A user's model of a box as a plant.

    Args:
        box: The box; its joints are found in the model by their names.
        labels: Labels of the joints, in panel order; they are drawn over pictures.
        settings: The file, the strength of a push, the camera.
        rng: The trial's random stream for the plant; the noise of depth draws from a child of it.

    Raises:
        BadFile: If the model cannot be read, differs from the digest in the settings, or lacks a joint.
        PlantFault: If it does not rest in the initial configuration.
    """

    def __init__(
        self,
        box: Lockbox,
        *,
        labels: tuple[str, ...],
        settings: UserModelSettings,
        rng: np.random.Generator,
    ) -> None:
        self._file, self._joints = _load(box, settings)
        self._joints.start(box.initial)
        self._names, self._labels = box.names, labels
        self._board = _board(self._joints, box)
        self._camera = PlantCamera(
            self._joints.model,
            self._joints.data,
            mechanism=self._joints,
            panel=self._board,
            settings=settings,
            rng=rng.spawn(1)[0],
            eye=CAMERA,
        )

    @property
    def facts(self) -> Mapping[str, Fact]:
        """Engine, settings, that the model is the user's, checksums of its files, and the renderer."""
        return {
            **self._camera.facts,
            "mechanism": "a user's model, pushed by a generalised force",
            "model_sha256": self._file.sha256,
            "model_parts_sha256": self._file.parts_sha256 or None,
        }

    def observe(self) -> Snapshot:
        """The truth now."""
        return Snapshot(
            configuration=self._joints.configuration(),
            look=partial(self._labelled, self._camera.look_now()),
            render=partial(self._labelled_as_if, self._camera.look_as_told()),
        )

    def attempt(self, joint: int) -> Snapshot:
        """Attempt a joint, by index in panel order.

        Raises:
            PlantFault: If a joint stays between its ends, another joint moves, or the simulation becomes unstable.
        """
        before = self._joints.configuration()
        self._camera.end_moment()
        self._joints.push(joint)
        after = self._joints.configuration()
        if not self._joints.resting():
            raise PlantFault(f"joint {joint} was pushed in {bits(before)}; now: {self._joints.where()}")
        if any(was != now for i, (was, now) in enumerate(zip(before, after, strict=True)) if i != joint):
            raise PlantFault(f"another joint moved with joint {joint}: {bits(before)} became {bits(after)}")
        return replace(self.observe(), joint=joint, outcome="moved" if after[joint] != before[joint] else "blocked")

    def close(self) -> None:
        """Release the renderer."""
        self._camera.close()

    def _labelled(self, look: Callable[[], Frame]) -> Frame:
        return self._with_labels(look(), self._joints.configuration())

    def _labelled_as_if(self, look: Callable[[Configuration], Frame], configuration: Configuration) -> Frame:
        return self._with_labels(look(configuration), configuration)

    def _with_labels(self, frame: Frame, configuration: Configuration) -> Frame:
        places = _points(self._joints, self._names, configuration, ("label-", ""))
        seen = frame.camera.project(self._board.in_board(places))[:, :2]
        return replace(frame, rgb=draw_labels(frame.rgb, self._labels, seen))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _BoardGeometry:
    """Pose of the board in the world, shape (4, 4), and both end positions of every handle in its frame, metres."""

    pose: NDArray[np.float64]
    handles: NDArray[np.float64]

    def in_board(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points of the world in the frame of the board, shape (..., 3)."""
        return _inside(self.pose, points)


def _load(box: Lockbox, settings: UserModelSettings) -> tuple[MjcfModel, ModelJoints]:
    path = Path(settings.model)
    file = read_model(path, settings.folder)
    if settings.digest not in ("", file.digest):
        raise BadFile(path, f"another model: its digest is {file.digest}, {settings.digest} was asked for")
    try:
        return file, ModelJoints(compile_model(file), box, force=settings.force, torque=settings.torque)
    except BadValue as error:
        raise BadFile(path, str(error)) from None


def _board(joints: ModelJoints, box: Lockbox) -> _BoardGeometry:
    model, pose = joints.model, np.eye(4)
    seen = joints.posed(box.initial)
    mujoco.mj_kinematics(model, seen)
    if (body := mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, PANEL)) >= 0:
        pose[:3, :3], pose[:3, 3] = seen.xmat[body].reshape(3, 3), seen.xpos[body]
    ends = [_points(joints, box.names, (position,) * len(box.names), ("",)) for position in (False, True)]
    return _BoardGeometry(pose=pose, handles=_inside(pose, np.stack(ends, axis=1)))


def _inside(pose: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    inside: NDArray[np.float64] = (points - pose[:3, 3]) @ pose[:3, :3]
    return inside


def _points(
    joints: ModelJoints, names: Sequence[str], configuration: Configuration, prefixes: Sequence[str]
) -> NDArray[np.float64]:
    """For each joint the first site that is there, by a prefix and its name, else its body's centre of mass; world."""
    data = joints.posed(configuration)
    mujoco.mj_kinematics(joints.model, data)
    points = np.array(data.xipos[joints.bodies])
    for joint, name in enumerate(names):
        for prefix in reversed(prefixes):
            if (site := mujoco.mj_name2id(joints.model, mujoco.mjtObj.mjOBJ_SITE, prefix + name)) >= 0:
                points[joint] = data.site_xpos[site]
    return points
