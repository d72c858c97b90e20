"""A tagged board, a camera and views of them, all poses known, without a picture."""

from functools import cache

import numpy as np
from lockprobe_robot.box_model.panel import lay_out_panel
from lockprobe_robot.box_model.tag_layout import place_tags
from lockprobe_robot.calibration.calibrate import BoardView
from lockprobe_robot.calibration.views import Intrinsics
from scipy.spatial.transform import Rotation

from lockprobe.boxes.families import box

BOX = "chain-2"
CAMERA = Intrinsics(width=640, height=480, focal=(433.0, 433.0), centre=(319.5, 239.5))


@cache
def board():
    panel = lay_out_panel(box(BOX))
    return panel, place_tags(panel)


def eye():
    """Camera in hand."""
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler("zyx", [80, -8, 5], degrees=True).as_matrix()
    pose[:3, 3] = (0.055, -0.032, 0.041)
    return pose


def camera_pose(panel, rng, tilt=25.0, roll=45.0, axes="xyz"):
    angles = np.radians([tilt, tilt, roll]) * rng.uniform(-1, 1, 3)
    turned = np.eye(4)
    used = [angle if axis in axes else 0.0 for axis, angle in zip("xyz", angles, strict=True)]
    turned[:3, :3] = (Rotation.from_euler("x", np.pi) * Rotation.from_euler("xyz", used)).as_matrix()
    turned[:3, 3] = (*rng.uniform(-0.02, 0.02, 2), 0) - rng.uniform(0.4, 0.5) * turned[:3, 2]
    return panel.pose @ turned


def views(count=12, seed=1, millimetres=0.0, **turned):
    """Views of a board; the hand's positions have noise."""
    panel, rng, found = board()[0], np.random.default_rng(seed), []
    for number in range(count):
        pose = camera_pose(panel, rng, **turned)
        hand = pose @ np.linalg.inv(eye())
        hand[:3, 3] += 1e-3 * millimetres * rng.standard_normal(3)
        seen = np.linalg.inv(pose) @ panel.pose
        found.append(BoardView(picture=f"{number}.png", hand=hand, board=seen, tags=4, reprojection=0.1))
    return found
