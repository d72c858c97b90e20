"""The camera on a hand shows points where a pinhole camera at its pose shows them."""

import mujoco
import numpy as np
from lockprobe_robot.rendering.hand_camera import HandCamera
from scipy.spatial.transform import Rotation


def test_a_ball_is_seen_where_a_pinhole_camera_sees_it():
    spec = mujoco.MjSpec()
    ball = np.array([0.1, -0.05, 0.02])
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.01, 0, 0], pos=ball, rgba=[1, 0, 0, 1])
    spec.visual.headlight.ambient = [1, 1, 1]
    camera = HandCamera(spec, width=320, height=240, fovy=50.0)
    assert camera.name
    for turn in ([0, 0, 0], [20, -15, 40], [-10, 25, 170]):
        pose = np.eye(4)
        pose[:3, :3] = (Rotation.from_euler("x", np.pi) * Rotation.from_euler("xyz", turn, degrees=True)).as_matrix()
        pose[:3, 3] = ball - 0.5 * pose[:3, 2] + 0.05 * pose[:3, 0] + 0.03 * pose[:3, 1]
        red = camera.look(pose)[..., 0] > 60
        rows, columns = np.nonzero(red)
        seen = pose[:3, :3].T @ (ball - pose[:3, 3])
        expected = np.array([159.5, 119.5]) + camera.focal * seen[:2] / seen[2]
        np.testing.assert_allclose([columns.mean(), rows.mean()], expected, atol=0.6)
    camera.close()
