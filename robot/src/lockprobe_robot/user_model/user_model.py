"""The plant ``twin?model=FILE``: a user's own MuJoCo model of a box, pushed by generalised forces; and its check."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from lockprobe.boxes.box import Configuration, Lockbox, bits
from lockprobe.foundation.errors import BadFile, BadValue, PlantFault
from lockprobe.trial.pictures.frame import Frame
from lockprobe_robot.simulated_plant import SimulatedPlant
from lockprobe_robot.twin_settings import UserModelSettings
from lockprobe_robot.user_model.mjcf_file import MjcfModel
from lockprobe_robot.user_model.model_joints import ModelJoints

PANEL = "panel"
"""Body that is the board: z out of it. Without it, the board is the frame of the world."""

MOST_CONFIGURATIONS = 64
"""Configurations in which joints are pushed before a study; if trials can reach more, a sample with a fixed seed."""

_LETTER = 0.05
"""Height of the letters that are drawn over a picture, as a share of its height."""


class UserModel(SimulatedPlant):
    """A user's model of a box as a plant, which finds joints by their names and draws labels over pictures.

    The camera draws from a child of ``rng``.

    Raises:
        BadFile: If the model cannot be read, differs from the digest in the settings, or lacks a joint.
        PlantFault: If it does not rest in the initial configuration.
    """

    joints: ModelJoints

    def __init__(
        self, box: Lockbox, *, labels: tuple[str, ...], settings: UserModelSettings, rng: np.random.Generator
    ) -> None:
        self.joints = joints_of(box, settings)
        self.joints.start(box.initial)
        self._labels = labels
        self._pose = np.eye(4)
        if (body := mujoco.mj_name2id(self.joints.model, mujoco.mjtObj.mjOBJ_BODY, PANEL)) >= 0:
            seen = self._seen(box.initial)
            self._pose[:3, :3], self._pose[:3, 3] = seen.xmat[body].reshape(3, 3), seen.xpos[body]
        ends = [self._points((position,) * len(box.names), ("",)) for position in (False, True)]
        handles = np.stack(ends, axis=1)
        super().__init__(self.joints, pose=self._pose, handles=handles, settings=settings, rng=rng.spawn(1)[0])

    def _look(self, attempts: int, configuration: Configuration | None) -> Frame:
        """A picture with the labels over it, white with a dark outline: the model has none."""
        frame = super()._look(attempts, configuration)
        if not self._settings.labels:
            return frame
        image = Image.fromarray(frame.rgb)
        draw, font = ImageDraw.Draw(image), ImageFont.load_default(_LETTER * image.height)
        shown = self.joints.configuration() if configuration is None else configuration
        places = frame.camera.project(self._points(shown, ("label-", "")))
        for label, (column, row, _) in zip(self._labels, places, strict=True):
            if 0 <= column < image.width and 0 <= row < image.height:
                at = (float(column), float(row))
                draw.text(at, label, (255, 255, 255), font, anchor="mm", stroke_width=2, stroke_fill=(20, 20, 20))
        return replace(frame, rgb=np.asarray(image))

    def _points(self, configuration: Configuration, prefixes: Sequence[str]) -> NDArray[np.float64]:
        """For each joint the first site by a prefix and its name, else its body's middle; in the frame of the board."""
        data = self._seen(configuration)
        points = np.array(data.xipos[self.joints.bodies])
        for joint, name in enumerate(self.joints.names):
            for prefix in reversed(prefixes):
                if (site := mujoco.mj_name2id(self.joints.model, mujoco.mjtObj.mjOBJ_SITE, prefix + name)) >= 0:
                    points[joint] = data.site_xpos[site]
        inside: NDArray[np.float64] = (points - self._pose[:3, 3]) @ self._pose[:3, :3]
        return inside

    def _seen(self, configuration: Configuration) -> mujoco.MjData:
        data = self.joints.posed(configuration)
        mujoco.mj_kinematics(self.joints.model, data)
        return data


def joints_of(box: Lockbox, settings: UserModelSettings) -> ModelJoints:
    """The joints of a box in the model that the settings name.

    Raises:
        BadFile: If the model cannot be read, differs from the digest in the settings, or lacks a joint.
    """
    path = Path(settings.model)
    model = MjcfModel(path, settings.digest).compile()
    try:
        return ModelJoints(model, box, force=settings.force, torque=settings.torque)
    except BadValue as error:
        raise BadFile(path, str(error)) from None


def check_model(box: Lockbox, settings: UserModelSettings) -> int:
    """Push every joint in the configurations that are reachable before the target moves, up to a number of them.

    The model is only pushed, never set to a configuration. So parts without a name in the box (bolts, gears) have the
    positions that an agent's attempts give them.

    Returns:
        The number of configurations.

    Raises:
        BadFile: If the model cannot be read or lacks a joint; if it does not rest in the initial configuration; if a
            joint moves against the rules, does not move although the rules allow it, stops between its ends or moves
            another joint. The message names the configuration and the joint.
    """
    joints = joints_of(box, settings)
    try:
        joints.start(box.initial)
    except PlantFault as fault:
        raise BadFile(settings.model, str(fault)) from None
    rng = np.random.default_rng(0)
    frontier = [(box.initial, copy.copy(joints.data))]
    known, checked = {box.initial}, 0
    while frontier and checked < MOST_CONFIGURATIONS:
        before, state = frontier.pop(int(rng.integers(len(frontier))))
        checked += 1
        for joint, name in enumerate(box.names):
            mujoco.mj_copyData(joints.data, joints.model, state)
            allowed, why = box.may_move(before, joint), ""
            try:
                joints.push(joint)
                after = joints.configuration_after(joint, before, locked=not allowed)
                if (moved := after[joint] != before[joint]) != allowed:
                    why = f"the model {'moved' if moved else 'held'} {name} ({joints.where()})"
            except PlantFault as fault:
                why = str(fault)
            if why:
                where = f"in configuration {bits(before)} ({', '.join(box.names)}), {name} was pushed"
                raise BadFile(
                    settings.model, f"{where}: the rules {'let it move' if allowed else 'lock it'}, and {why}"
                )
            if name != box.target and after not in known:
                known.add(after)
                frontier.append((after, copy.copy(joints.data)))
    return checked
