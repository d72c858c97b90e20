"""The hand: its cage fits the knob, its fingers are springs, its sensor tells forces."""

import math

import mujoco
import numpy as np
import pytest
from arm.slider_scene import slider
from lockprobe_robot.arm.hand import FINGERS, HAND_RADIUS, REACH, TOOL
from lockprobe_robot.arm.panda import HOME

KNOB = 0.015


def fingers(model):
    return [model.geom(f"finger-{number}") for number in range(FINGERS)]


def test_a_knob_fits_in_and_not_out_between_two_fingers():
    thickness = fingers(slider())[0].size[0]
    ring = HAND_RADIUS - thickness
    assert ring - thickness - KNOB > 0.01
    assert 2 * ring * math.sin(math.pi / FINGERS) - 2 * thickness < 2 * KNOB


def test_fingertips_end_where_they_are_said_to():
    model = slider()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    hand, turn = data.body("hand").xpos, data.body("hand").xmat.reshape(3, 3)
    for geom in fingers(model):
        centre, along = data.geom(geom.id).xpos, data.geom(geom.id).xmat.reshape(3, 3)[:, 2]
        tip = (
            max(centre + along * geom.size[1], centre - along * geom.size[1], key=lambda p: (p - hand) @ turn[:, 2])
            - hand
        ) @ turn
        assert tip[2] + geom.size[0] == pytest.approx(TOOL + REACH)
        assert math.hypot(tip[0], tip[1]) + geom.size[0] == pytest.approx(HAND_RADIUS)


@pytest.mark.parametrize("push", [(7.0, 0.0, 0.0), (0.0, -4.0, 0.0), (2.0, 3.0, 5.0)])
def test_the_sensor_reads_a_known_force_on_the_hand(push):
    """With the arm held still: what a push adds to the reading is the push, seen from the flange with opposite sign."""
    model = slider()
    model.opt.gravity[:] = 0
    for joint in range(7):
        model.dof_armature[model.joint(f"arm-{joint + 1}").dofadr] = 1e6
    data = mujoco.MjData(model)
    place = model.joint("arm-1").qposadr[0]
    data.qpos[place : place + 7] = HOME
    body = model.body("hand").id
    for _ in range(500):
        data.xfrc_applied[body, :3] = push
        mujoco.mj_step(model, data)
    reading = data.site("wrench").xmat.reshape(3, 3) @ data.sensor("force").data
    assert np.allclose(-reading, push, atol=0.02)
