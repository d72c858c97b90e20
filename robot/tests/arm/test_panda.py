"""The arm's kinematics, limits and masses against what is published."""

import mujoco
import numpy as np
import pytest
from lockprobe_robot.arm.panda import DH, FLANGE, HOME, LINKS, LOWER, TORQUE_LIMITS, UPPER, add_panda
from scipy.spatial.transform import Rotation


def forward(angles):
    """Forward kinematics from the manufacturer's table, written without what is tested."""
    pose = np.eye(4)
    table = [
        (0, 0.333, 0), (0, 0, -np.pi / 2), (0, 0.316, np.pi / 2), (0.0825, 0, np.pi / 2),
        (-0.0825, 0.384, -np.pi / 2), (0, 0, np.pi / 2), (0.088, 0, np.pi / 2), (0, 0.107, 0),
    ]  # fmt: skip
    for (a, d, alpha), theta in zip(table, [*angles, 0.0], strict=True):
        for turn, shift in (
            (Rotation.from_euler("x", alpha), (a, 0, 0)),
            (Rotation.from_euler("z", theta), (0, 0, d)),
        ):
            step = np.eye(4)
            step[:3, :3], step[:3, 3] = turn.as_matrix(), shift
            pose = pose @ step
    return pose


@pytest.fixture(scope="module")
def model():
    spec = mujoco.MjSpec()
    add_panda(spec).add_site(name="end")
    return spec.compile()


@pytest.mark.parametrize("seed", range(10))
def test_forward_kinematics_are_those_of_the_published_table(model, seed):
    data = mujoco.MjData(model)
    data.qpos[:] = np.random.default_rng(seed).uniform(LOWER, UPPER)
    mujoco.mj_forward(model, data)
    wanted = forward(data.qpos)
    assert np.allclose(data.site("end").xpos, wanted[:3, 3], atol=1e-12)
    assert np.allclose(data.site("end").xmat.reshape(3, 3), wanted[:3, :3], atol=1e-12)


@pytest.mark.parametrize("degrees", [True, False])
def test_limits_are_in_radians_whatever_the_unit_of_the_scene(degrees):
    spec = mujoco.MjSpec()
    spec.compiler.degree = degrees
    add_panda(spec)
    model = spec.compile()
    assert np.allclose(model.jnt_range, np.stack([LOWER, UPPER], axis=1))
    assert model.jnt_limited.all()
    assert np.allclose(model.actuator_ctrlrange[:, 1], TORQUE_LIMITS)


def test_masses_are_the_identified_ones(model):
    assert np.allclose([model.body(f"link{n}").mass[0] for n in range(1, 8)], [link.mass for link in LINKS])
    assert sum(link.mass for link in LINKS) == pytest.approx(16.06, abs=0.01)


def test_gravity_at_rest_is_what_the_masses_weigh(model):
    """The moment about the shoulder, from masses and centres alone."""
    data = mujoco.MjData(model)
    data.qpos[:] = HOME
    mujoco.mj_forward(model, data)
    shoulder, axis = data.joint("arm-2").xanchor, data.joint("arm-2").xaxis
    moment = np.zeros(3)
    for number in range(2, 8):
        body = data.body(f"link{number}")
        moment += np.cross(body.xipos - shoulder, LINKS[number - 1].mass * np.array([0, 0, -9.81]))
    assert data.qfrc_bias[1] == pytest.approx(-moment @ axis, rel=1e-6)


def test_the_homing_pose_is_within_limits():
    assert ((LOWER < HOME) & (HOME < UPPER)).all()
    assert (len(DH), FLANGE) == (7, 0.107)
