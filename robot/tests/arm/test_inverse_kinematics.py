"""Inverse kinematics: what is found is there, within limits; what is out of reach is not found."""

import math

import mujoco
import numpy as np
import pytest
from arm.slider_scene import AXIS, slider
from lockprobe_robot.arm.inverse_kinematics import InverseKinematics
from lockprobe_robot.arm.panda import LOWER, UPPER


@pytest.fixture(scope="module")
def model():
    return slider()


@pytest.mark.parametrize(("tilt", "height"), [(0, 0.16), (20, 0.2), (45, 0.45), (60, 0.6), (80, 0.8)])
@pytest.mark.parametrize(("forward", "left"), [(0.5, 0.0), (0.45, 0.3), (0.55, -0.3)])
def test_the_tool_is_where_it_was_asked_to_be(model, forward, left, tilt, height):
    """What a steep panel needs is height: under it the wrist would have to bend further than it can."""
    place = (forward, left, height)
    axis = np.array([math.sin(math.radians(tilt)), 0, -math.cos(math.radians(tilt))])
    angles = InverseKinematics(model).solve(np.array(place), axis)
    assert angles is not None
    assert ((angles > LOWER) & (angles < UPPER)).all()
    data = mujoco.MjData(model)
    first = model.joint("arm-1").qposadr[0]
    data.qpos[first : first + 7] = angles
    mujoco.mj_forward(model, data)
    assert np.allclose(data.site("tool").xpos, place, atol=3e-4)
    assert data.site("tool").xmat.reshape(3, 3)[:, 2] @ axis > math.cos(math.radians(0.1))


def test_the_same_place_gives_the_same_angles(model):
    place = np.array([0.5, 0.1, 0.2])
    solver = InverseKinematics(model)
    first = solver.solve(place, AXIS)
    solver.solve(np.array([0.45, -0.2, 0.3]), AXIS)
    assert np.array_equal(first, solver.solve(place, AXIS))


@pytest.mark.parametrize("place", [(1.2, 0.0, 0.3), (0.0, 0.0, 2.0)])
def test_what_is_out_of_reach_is_not_found(model, place):
    assert InverseKinematics(model).solve(np.array(place), AXIS) is None


def test_a_steep_panel_near_the_ground_is_out_of_reach(model):
    steep = np.array([math.sin(1.0), 0, -math.cos(1.0)])
    assert InverseKinematics(model).solve(np.array([0.45, 0.0, 0.16]), steep) is None
    assert InverseKinematics(model).solve(np.array([0.45, 0.0, 0.55]), steep) is not None
