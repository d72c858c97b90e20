"""The plant's camera sees the board and every handle, from either viewpoint."""

import math

import numpy as np
import pytest
from box_model.scenes import scene_of
from lockprobe_robot.box_model.mounted_joint import KNOB_RADIUS
from lockprobe_robot.box_model.view import view_of

from lockprobe.boxes.families import box


@pytest.mark.parametrize("camera", ["plain", "oblique"])
@pytest.mark.parametrize(("name", "tilt"), [("chain-2", 0), ("chain-4", 20), ("chain-8", 60)])
@pytest.mark.parametrize("aspect", [4 / 3, 0.5])
def test_board_and_handles_are_in_the_picture_with_a_margin(name, tilt, camera, aspect):
    scene = scene_of(box(name), tilt=tilt, viewpoint=camera)
    panel, view = scene.panel, view_of(scene.panel, scene.appearance, aspect=aspect)
    corners = np.array([[x, y, 0] for x in (-1, 1) for y in (-1, 1)]) * np.array([*panel.size, 0]) / 2
    rims = panel.handles[:, :, None] + KNOB_RADIUS * np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]])
    seen = [view.project(panel.in_world(points)) for points in (corners, rims.reshape(-1, 3))]
    assert 0.7 < np.abs(seen[0]).max() < 0.87
    assert np.abs(seen[1]).max() < 0.9
    assert seen[0][1, 1] > seen[0][0, 1], "up on the panel is up in the picture"
    assert seen[0][2, 0] > seen[0][0, 0], "right on the panel is right in the picture"


def test_the_oblique_viewpoint_is_as_far_away_and_to_the_left():
    scene = scene_of(box("chain-4"))
    plain, oblique = (
        view_of(scene.panel, scene_of(box("chain-4"), viewpoint=camera).appearance, aspect=4 / 3)
        for camera in ("plain", "oblique")
    )
    away = [view.position - scene.panel.pose[:3, 3] for view in (plain, oblique)]
    assert np.linalg.norm(away[1]) == pytest.approx(np.linalg.norm(away[0]))
    turned = math.degrees(math.acos(away[0] @ away[1] / (away[0] @ away[0])))
    assert turned == pytest.approx(28)
    assert away[1] @ scene.panel.pose[:3, 0] < -0.3
    assert np.linalg.det(oblique.axes) == pytest.approx(1)
