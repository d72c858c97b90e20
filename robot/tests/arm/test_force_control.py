"""The inner loop: it stands, it gives way as stiffness says, it follows."""

import mujoco
import numpy as np
import pytest
from arm.slider_scene import AXIS, TOP, arm_over, slider
from lockprobe_robot.arm.force_control import ForceController
from lockprobe_robot.arm.inverse_kinematics import InverseKinematics
from lockprobe_robot.arm.panda import HOME, TORQUE_LIMITS

ABOVE = TOP - 0.1 * AXIS
STILL = np.zeros(3)


@pytest.fixture(scope="module")
def model():
    return slider()


def held(model, push, stiffness, seconds=1.5):
    """Where the tool ends under a push while it is drawn to a point; with its turn before and after."""
    data = mujoco.MjData(model)
    controller = ForceController(model, data)
    angles = InverseKinematics(model).solve(ABOVE, AXIS)
    controller.joints[:] = angles
    mujoco.mj_forward(model, data)
    turn = controller.turn.copy()
    for _ in range(round(seconds / model.opt.timestep)):
        mujoco.mj_step1(model, data)
        mujoco.mj_applyFT(
            model,
            data,
            np.array(push),
            np.zeros(3),
            controller.tool,
            model.body("hand").id,
            forces := np.zeros(model.nv),
        )
        data.qfrc_applied[:] = forces
        controller.pull(ABOVE, turn, STILL, STILL, stiffness=stiffness, posture=angles)
        mujoco.mj_step2(model, data)
    return controller.tool - ABOVE, turn.T @ controller.turn, controller.joints - angles


def test_nothing_pushes_and_it_stands(model):
    offset, turn, moved = held(model, (0, 0, 0), 1500.0)
    assert np.abs(offset).max() < 1e-4
    assert np.allclose(turn, np.eye(3), atol=1e-3)
    assert np.abs(moved).max() < 1e-3


@pytest.mark.parametrize("stiffness", [1500.0, 2500.0])
@pytest.mark.parametrize("push", [(20.0, 0.0, 0.0), (0.0, 20.0, 0.0), (0.0, 0.0, 20.0)])
def test_a_push_moves_it_by_force_over_stiffness(model, push, stiffness):
    offset, turn, _ = held(model, push, stiffness)
    assert np.allclose(offset, np.array(push) / stiffness, atol=3e-4)
    assert np.arccos((np.trace(turn) - 1) / 2) < 0.02


def test_it_follows_a_motion_of_its_joints(model):
    arm, data = arm_over(model)
    controller = arm._controller
    for step in range(500):
        time = (step + 1) * 0.002
        wave = np.full(7, 0.2)
        mujoco.mj_step1(model, data)
        controller.track(HOME + wave * (1 - np.cos(3 * time)), 3 * wave * np.sin(3 * time), 9 * wave * np.cos(3 * time))
        mujoco.mj_step2(model, data)
    assert np.abs(controller.joints - HOME - 0.2 * (1 - np.cos(3.0))).max() < 2e-3


def test_torques_stay_within_their_limits(model):
    arm, data = arm_over(model)
    mujoco.mj_step1(model, data)
    arm._controller.track(HOME + 3, np.zeros(7), np.full(7, 500.0))
    assert (np.abs(data.ctrl) <= TORQUE_LIMITS).all()
    assert (np.abs(data.ctrl) == TORQUE_LIMITS).any()
