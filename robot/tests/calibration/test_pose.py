"""Rigid poses: laws."""

import numpy as np
import pytest
from lockprobe_robot.calibration.pose import PoseRows, angle_between, array_of, mean_pose, rows_of
from pydantic import TypeAdapter, ValidationError
from scipy.spatial.transform import Rotation


def pose(seed, degrees=180.0):
    rng = np.random.default_rng(seed)
    found = np.eye(4)
    axis = rng.standard_normal(3)
    found[:3, :3] = Rotation.from_rotvec(np.radians(degrees) * axis / np.linalg.norm(axis)).as_matrix()
    found[:3, 3] = rng.standard_normal(3)
    return found


@pytest.mark.parametrize("degrees", [0.01, 1.0, 90.0, 179.0])
def test_the_angle_is_that_of_the_rotation_between(degrees):
    first = pose(1, 40)
    assert angle_between(first, first @ pose(2, degrees)) == pytest.approx(degrees, abs=1e-6)


def test_the_mean_of_a_rotation_and_its_opposite_is_none():
    middle, turn = pose(3, 50), pose(4, 10)
    turn[:3, 3] = 0
    found = mean_pose([middle @ turn, middle @ np.linalg.inv(turn)])
    np.testing.assert_allclose(found, middle, atol=1e-12)


def test_rows_give_the_pose_back_and_only_rigid_poses_pass():
    check = TypeAdapter(PoseRows).validate_python
    np.testing.assert_allclose(array_of(check(rows_of(pose(5, 33)))), pose(5, 33), atol=2e-7)
    for wrong in (np.diag([1, 1, -1, 1]), np.diag([2, 1, 1, 1]), np.eye(4) * 2, pose(6, 20).T, np.full((4, 4), np.nan)):
        with pytest.raises(ValidationError):
            check(wrong.tolist())
