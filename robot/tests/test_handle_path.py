"""The way of a handle: from end to end, on the board, for any pose of it."""

from dataclasses import replace

import numpy as np
import pytest
from lockprobe_robot.box_model.panel import lay_out_panel

from lockprobe.boxes.families import box

PANEL = lay_out_panel(box("chain-4"))


@pytest.mark.parametrize("joint", range(4))
def test_there_and_back_is_the_same_way_between_the_ends_of_the_handle(joint):
    there, back = (PANEL.handle_path(joint, position) for position in (False, True))
    assert np.allclose(there.points, back.points[::-1])
    assert np.allclose(there.points[[0, -1]], PANEL.in_world(PANEL.handles[joint]))
    assert np.allclose((there.points - there.points[0]) @ there.axis, 0)


def test_a_board_elsewhere_is_a_way_elsewhere():
    pose = np.array([[0.0, -1.0, 0.0, 0.4], [1.0, 0.0, 0.0, -0.1], [0.0, 0.0, 1.0, 0.2], [0.0, 0.0, 0.0, 1.0]])
    here, there = (replace(PANEL, pose=at).handle_path(1, False) for at in (np.eye(4), pose))
    assert np.allclose(there.points, here.points @ pose[:3, :3].T + pose[:3, 3])
    assert there.axis.tolist() == [0, 0, -1]
    assert here.length == pytest.approx(there.length)
