"""The hand: its ring goes round a knob, its plate yields and springs back, its sensor tells forces."""

import mujoco
import numpy as np
import pytest
from arm.slider_scene import slider
from lockprobe_robot.arm.hand import FLARE, RING, THICKNESS
from lockprobe_robot.arm.panda import HOME
from lockprobe_robot.box_model.mounted_joint import KNOB_RADIUS


def test_a_knob_fits_in_with_room_and_is_led_in_from_24_mm_beside_it():
    assert RING - THICKNESS - KNOB_RADIUS >= 0.015
    assert FLARE - 0.0035 > 0.024 + KNOB_RADIUS / 2  # the knob's top is round


@pytest.mark.parametrize("push", [(7.0, 0.0, 0.0), (0.0, -4.0, 0.0), (2.0, 3.0, 5.0)])
def test_the_sensor_reads_a_known_force_on_the_ring_which_yields_and_comes_back(push):
    """With the arm held still: what a push adds to the reading is the push, seen from the flange with opposite sign."""
    model = slider()
    model.opt.gravity[:] = 0
    for joint in range(7):
        model.dof_armature[model.joint(f"arm-{joint + 1}").dofadr] = 1e6
    data = mujoco.MjData(model)
    place = model.joint("arm-1").qposadr[0]
    data.qpos[place : place + 7] = HOME
    yielded = {}
    for newtons in (np.array(push), np.zeros(3)):
        for _ in range(500):
            data.xfrc_applied[model.body("plate").id, :3] = newtons
            mujoco.mj_step(model, data)
        reading = data.site("wrench").xmat.reshape(3, 3) @ data.sensor("force").data
        assert np.allclose(-reading, newtons, atol=0.02)
        yielded[newtons.any()] = abs(float(data.joint("hand-x").qpos[0])) + abs(float(data.joint("hand-y").qpos[0]))
    assert yielded[True] > 2e-4
    assert yielded[False] < 1e-6
