"""What the cameras of a scene see."""

import mujoco
import numpy as np
import pytest
from plants.scene.scenes import scene_of

from lockprobe.lockbox.families import box
from lockprobe.pictures.frame import Camera
from lockprobe.plants.scene.cameras import EYE


@pytest.mark.parametrize("name", ["chain-2", "chain-4", "chain-8", "branched"])
@pytest.mark.parametrize("tilt", [0, 20, 60])
def test_the_camera_sees_the_whole_board_with_a_margin(name, tilt):
    scene = scene_of(box(name), tilt=tilt)
    assert scene.camera == EYE
    model = scene.spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    seen = model.camera(scene.camera).id
    turn = data.cam_xmat[seen].reshape(3, 3) @ np.diag([1, -1, -1])
    pose = np.eye(4)
    pose[:3, :3] = turn.T @ scene.panel.pose[:3, :3]
    pose[:3, 3] = turn.T @ (scene.panel.pose[:3, 3] - data.cam_xpos[seen])
    focal = 240 / np.tan(np.radians(model.cam_fovy[seen]) / 2)
    half = np.array([*scene.panel.size, 0]) / 2
    corners = half * [[x, y, 0] for x in (-1, 1) for y in (-1, 1)]
    points = Camera(width=640, height=480, focal=focal, panel=pose).project(corners)
    share = np.abs(points[:, :2] - (319.5, 239.5)) / (320, 240)
    assert 0.75 < share.max() < 0.85
    assert points[1, 1] < points[0, 1], "up on the panel is up in the picture"
    assert points[2, 0] > points[0, 0], "right on the panel is right in the picture"


def test_a_wide_picture_is_used_to_its_sides_and_a_tall_one_too():
    """Each is filled in one direction, so that the angle of sight differs with the shape of the picture."""
    shares = []
    for width, height in ((960, 240), (640, 480), (240, 960)):
        scene = scene_of(box("chain-4"), width=width, height=height)
        model = scene.spec.compile()
        eye = model.camera(EYE)
        up = np.tan(np.radians(eye.fovy[0]) / 2) * np.linalg.norm(eye.pos - scene.panel.pose[:3, 3])
        shares.append([scene.panel.size[0] / 2 / (up * width / height), scene.panel.size[1] / 2 / up])
    assert all(0.7 < max(share) < 0.9 for share in shares)
    assert [share[1] == max(share) for share in shares] == [True, False, False]


def test_one_camera_sees_board_and_arm_from_aside():
    scene = scene_of(box("chain-4"))
    model = scene.spec.compile()
    film = model.camera("oblique")
    pose = np.zeros(9)
    mujoco.mju_quat2Mat(pose, film.quat)
    half = np.tan(np.radians(film.fovy[0]) / 2)
    for point in (scene.panel.pose[:3, 3], np.array([0.0, 0.0, 0.3])):
        right, up, back = pose.reshape(3, 3).T @ (point - film.pos)
        assert back < 0
        assert abs(up / back) < half
        assert abs(right / back) < half * 4 / 3
