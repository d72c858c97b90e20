"""A film sees a simulation at regular intervals, through a camera beside the arm."""

import mujoco
import numpy as np
import pytest
from lockprobe_robot.filming import FILM_CAMERA, Filming, add_film_camera


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


def test_the_camera_stands_beside_the_base_and_looks_past_it_to_the_board():
    model, data = falling()
    mujoco.mj_forward(model, data)
    camera = data.camera(FILM_CAMERA)
    assert camera.xpos == pytest.approx([1.25, 0.8, 1.15])
    ahead = -camera.xmat.reshape(3, 3)[:, 2]
    target = np.array([0.22, 0.0, 0.28])
    assert np.cross(ahead, target - camera.xpos) == pytest.approx(0, abs=1e-9)
    assert ahead @ (target - camera.xpos) > 0
