"""A film sees a simulation at regular intervals, through a camera beside the arm."""

import mujoco
import numpy as np
import pytest
from lockprobe_robot.filming import BOARD, FILM_CAMERA, Filming, add_film_camera


def falling():
    spec = mujoco.MjSpec()
    add_film_camera(spec)
    body = spec.worldbody.add_body()
    body.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE)
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.1, 0, 0])
    model = spec.compile()
    return model, mujoco.MjData(model)


def test_it_is_called_25_times_in_a_simulated_second():
    model, data = falling()
    seen = []
    after_step = Filming(lambda model, data: seen.append(data.time), model, data)
    for _ in range(round(2 / model.opt.timestep)):
        mujoco.mj_step(model, data)
        after_step()
    assert len(seen) == pytest.approx(50, abs=1)
    assert np.diff(seen) == pytest.approx(0.04, abs=2 * model.opt.timestep)
    Filming(None, model, data)()


def test_the_camera_looks_at_the_board_from_the_side_of_the_arm_where_letters_are_upright():
    model, data = falling()
    mujoco.mj_forward(model, data)
    camera = data.camera(FILM_CAMERA)
    right, up, back = camera.xmat.reshape(3, 3).T
    assert np.cross(-back, BOARD - camera.xpos) == pytest.approx(0, abs=1e-9)
    letters_up = np.array([1.0, 0.0, 0.35])
    assert letters_up @ up > abs(letters_up @ right)
