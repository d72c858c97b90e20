"""The path of a handle on a panel, from one position to the other, for a hand that drags it."""

from __future__ import annotations

import numpy as np

from lockprobe_robot.arm.guarded_move import HandlePath
from lockprobe_robot.box_model.mounted_joint import KNOB_TOP
from lockprobe_robot.box_model.panel import PanelLayout

_POINTS = 33
"""Number of points on the path."""


def handle_path(panel: PanelLayout, joint: int, position: bool) -> HandlePath:
    """The path of a handle in the world of ``panel.pose``.

    Args:
        panel: The panel. For a real board, its pose is the measured one in the frame of the arm's base.
        joint: By index in panel order.
        position: The handle's present position; the path leads to the other one.
    """
    mounted = panel.mounted_joints[joint]
    fractions = np.linspace(1, 0, _POINTS) if position else np.linspace(0, 1, _POINTS)
    tops = np.array([[*mounted.knob(float(fraction)), KNOB_TOP] for fraction in fractions])
    return HandlePath(points=panel.in_world(tops), axis=-panel.pose[:3, 2])
