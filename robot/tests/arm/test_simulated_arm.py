"""The simulated arm: published kinematics, its reach, and springs."""

import math

import mujoco
import numpy as np
import pytest
from lockprobe_robot.arm.inverse_kinematics import InverseKinematics
from lockprobe_robot.arm.model import HOME, add_arm, add_hand
from lockprobe_robot.arm.simulated_arm import SimulatedArm
from lockprobe_robot.calibration.calibration_file import pose_of
from scipy.spatial.transform import Rotation

from lockprobe.foundation.errors import PlantFault

AXIS = np.array([0.0, 0.0, -1.0])


@pytest.fixture(scope="module")
def model():
    """The arm with its hand, alone."""
    spec = mujoco.MjSpec.from_string("<mujoco><option timestep='0.002' integrator='implicitfast'/></mujoco>")
    add_hand(spec, add_arm(spec))
    return spec.compile()


def forward(angles):
    """Forward kinematics from the manufacturer's table, written without what is tested."""
    pose = np.eye(4)
    table = [
        (0, 0.333, 0), (0, 0, -np.pi / 2), (0, 0.316, np.pi / 2), (0.0825, 0, np.pi / 2),
        (-0.0825, 0.384, -np.pi / 2), (0, 0, np.pi / 2), (0.088, 0, np.pi / 2), (0, 0.107, 0),
    ]  # fmt: skip
    for (a, d, alpha), theta in zip(table, [*angles, 0.0], strict=True):
        for turn, shift in ((Rotation.from_euler("x", alpha), (a, 0, 0)), (Rotation.from_euler("z", theta), (0, 0, d))):
            pose = pose @ pose_of(turn.as_matrix(), np.array(shift))
    return pose


def test_kinematics_limits_and_masses_are_the_published_ones():
    spec = mujoco.MjSpec()
    add_arm(spec).add_site(name="end")
    arm = spec.compile()
    data = mujoco.MjData(arm)
    lower, upper = arm.jnt_range.T
    assert lower[[0, 3, 5]] == pytest.approx([-2.8973, -3.0718, -0.0175])
    assert upper[[0, 3, 5]] == pytest.approx([2.8973, -0.0698, 3.7525])
    assert arm.actuator_ctrlrange[:, 1].tolist() == [87.0] * 4 + [12.0] * 3
    assert ((lower < HOME) & (upper > HOME)).all()
    assert sum(arm.body(f"arm-link{number}").mass[0] for number in range(1, 8)) == pytest.approx(16.06, abs=0.01)
    for seed in range(10):
        data.qpos[:] = np.random.default_rng(seed).uniform(lower, upper)
        mujoco.mj_forward(arm, data)
        wanted = forward(data.qpos)
        assert data.site("end").xpos == pytest.approx(wanted[:3, 3], abs=1e-12)
        assert data.site("end").xmat.reshape(3, 3) == pytest.approx(wanted[:3, :3], abs=1e-12)


@pytest.mark.parametrize(("tilt", "height"), [(0, 0.16), (45, 0.45), (80, 0.8)])
@pytest.mark.parametrize(("forward", "left"), [(0.5, 0.0), (0.45, 0.3), (0.55, -0.3)])
def test_the_tool_is_where_it_was_asked_to_be(model, forward, left, tilt, height):
    """What a steep panel needs is height: under it the wrist would have to bend further than it can."""
    place = np.array([forward, left, height])
    axis = np.array([math.sin(math.radians(tilt)), 0, -math.cos(math.radians(tilt))])
    solver = InverseKinematics(model)
    angles = solver.solve(place, axis)
    assert angles is not None
    data = mujoco.MjData(model)
    first = model.joint("arm-1").qposadr[0]
    data.qpos[first : first + 7] = angles
    mujoco.mj_forward(model, data)
    assert data.site("tool").xpos == pytest.approx(place, abs=3e-4)
    assert data.site("tool").xmat.reshape(3, 3)[:, 2] @ axis > math.cos(math.radians(0.1))
    assert np.array_equal(solver.solve(place, axis), angles)


def test_what_is_out_of_reach_breaks_the_trial_with_the_place(model):
    arm = SimulatedArm(model, mujoco.MjData(model), rng=np.random.default_rng(1))
    for place, axis in (((1.2, 0, 0.2), AXIS), ((0, 0, 2.0), AXIS), ((0.45, 0, 0.16), (math.sin(1), 0, -math.cos(1)))):
        assert not arm.reaches(np.array(place), np.array(axis))
    with pytest.raises(PlantFault, match=r"1\.2"):
        arm.reach(np.array([1.2, 0, 0.2]), AXIS)
