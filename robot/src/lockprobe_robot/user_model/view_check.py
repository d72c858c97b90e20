"""Which joints of a user's model the plant's camera does not see: outside the picture, or hidden."""

from __future__ import annotations

from collections.abc import Callable

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.box import Configuration, Lockbox
from lockprobe.trial.pictures.frame import Frame
from lockprobe_robot.geom_groups import SHOWN_GROUPS
from lockprobe_robot.user_model.compiled_model import CAMERA
from lockprobe_robot.user_model.model_joints import ModelJoints

__all__ = ["out_of_view"]

_CHANGED = 8
"""Difference of a colour, of 255, from which a pixel counts as changed."""

_SEEN = 1e-4
"""Share of pixels that a joint has to change when it moves: 31 of 640 x 480."""


def out_of_view(box: Lockbox, joints: ModelJoints, render: Callable[[Configuration], Frame]) -> dict[str, str]:
    """Why the camera does not see the position of a joint, for every joint that it does not see.

    A joint is outside if its handle is outside the picture at an end. It is hidden if hardly a pixel changes when it
    moves, with all other joints in their initial positions.

    Args:
        box: The box.
        joints: Its joints in the model.
        render: A picture without labels, with the joints in a configuration.

    Returns:
        Joint -> the reason in words.
    """
    found: dict[str, str] = {}
    for joint, name in enumerate(box.names):
        ends = [(*box.initial[:joint], position, *box.initial[joint + 1 :]) for position in (False, True)]
        frames = [render(configuration) for configuration in ends]
        outside = [str(end) for end in (0, 1) if _is_outside(frames[end], joint, end)]
        changed = int(_differ(frames[0].rgb, frames[1].rgb).sum())
        if outside:
            found[name] = f"its handle is outside the picture at position {' and '.join(outside)}"
        elif changed < _SEEN * frames[0].depth.size:
            covers = [_cover(joints, ends[end], joint, frames[end], end) for end in (0, 1)]
            before = " and ".join(dict.fromkeys(filter(None, covers)))
            found[name] = f"hidden{f' behind {before}' if before else ''}, its motion changes {changed} pixels"
    return found


def _is_outside(frame: Frame, joint: int, end: int) -> bool:
    column, row, depth = frame.camera.project(frame.handles)[joint, end]
    height, width = frame.depth.shape
    return bool(depth <= 0 or not -0.5 <= column < width - 0.5 or not -0.5 <= row < height - 0.5)


def _differ(one: NDArray[np.uint8], other: NDArray[np.uint8]) -> NDArray[np.bool_]:
    changed: NDArray[np.bool_] = (np.abs(one.astype(int) - other.astype(int)) > _CHANGED).any(2)
    return changed


def _cover(joints: ModelJoints, configuration: Configuration, joint: int, frame: Frame, end: int) -> str:
    """The body between the camera and a handle; empty if there is none, or none with a name."""
    model, data = joints.model, joints.posed(configuration)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_camlight(model, data)
    eye = data.cam_xpos[model.camera(CAMERA).id]
    away = np.array([*frame.camera.project(frame.handles)[joint, end, :2], 1.0])
    middle = np.array([(frame.camera.width - 1) / 2, (frame.camera.height - 1) / 2])
    across, down = (away[:2] - middle) / frame.camera.focal
    axes = data.cam_xmat[model.camera(CAMERA).id].reshape(3, 3)
    hit = np.array([-1], np.int32)
    shown = np.array(SHOWN_GROUPS, np.uint8)
    mujoco.mj_ray(model, data, eye, axes @ np.array([across, -down, -1.0]), shown, 1, -1, hit)
    if hit[0] < 0:
        return ""
    body = found = int(model.geom_bodyid[hit[0]])
    while body > 0 and body != joints.bodies[joint]:
        body = int(model.body_parentid[body])
    return "" if body == joints.bodies[joint] else str(model.body(found).name)
