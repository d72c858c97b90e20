"""Where the panel stands, and where the camera hangs."""

import math
from itertools import pairwise

import numpy as np
import pytest

from lockprobe.plants.scene.placement import camera_angle, panel_pose

SIZE = (0.56, 0.28)
DEGREES = [0, 10, 20, 30, 45, 60, 80]


@pytest.mark.parametrize("degrees", DEGREES)
def test_a_panel_faces_who_stands_before_it_and_clears_the_ground(degrees):
    tilt = math.radians(degrees)
    pose = panel_pose(SIZE, tilt, depth=0.1)
    right, up, out = pose[:3, :3].T
    assert np.allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3))
    assert np.allclose(np.cross(right, up), out)
    assert np.allclose(right, [0, -1, 0])
    assert math.degrees(math.acos(out[2])) == pytest.approx(degrees)
    assert out[0] <= 0
    corners = [
        pose[:3, 3] + x * right + y * up - z * out for x in (-0.28, 0.28) for y in (-0.14, 0.14) for z in (0, 0.1)
    ]
    assert min(corner[2] for corner in corners) > 0.02


def test_steeper_panels_stand_higher():
    heights = [panel_pose(SIZE, math.radians(degrees), depth=0.06)[2, 3] for degrees in DEGREES]
    assert heights[:3] == [heights[0]] * 3
    assert all(low < high for low, high in pairwise(heights[2:]))


def test_the_camera_follows_the_panel_as_far_as_it_can():
    angles = [math.degrees(camera_angle(math.radians(degrees))) for degrees in DEGREES]
    assert angles == pytest.approx([0, 10, 12, 12, 12, 20, 40])
