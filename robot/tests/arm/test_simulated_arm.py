"""The simulated arm with the guarded move: a knob that slides, one that is held, limits, luck."""

import mujoco
import numpy as np
import pytest
from arm.slider_scene import AXIS, PATH, TOP, TRAVEL, arm_over, slider
from lockprobe_robot.arm.guarded_move import GuardedMove
from lockprobe_robot.arm.panda import HOME, LOWER, UPPER, VELOCITY_LIMITS
from lockprobe_robot.arm.simulated_arm import SimulatedArm

from lockprobe.foundation.errors import PlantFault


def test_a_knob_that_slides_is_brought_to_its_end():
    arm, data = arm_over(slider())
    touch = GuardedMove().attempt(arm, PATH)
    assert touch.verdict == "moved"
    assert data.joint("joint-0").qpos[0] > 0.8 * TRAVEL
    assert touch.peak_force < 6


def test_a_knob_that_is_held_is_felt():
    arm, data = arm_over(slider(held=True))
    touch = GuardedMove().attempt(arm, PATH)
    assert touch.verdict == "blocked"
    assert 10 < touch.peak_force < 30
    assert data.joint("joint-0").qpos[0] < 0.002


def test_all_limits_are_kept_and_it_ends_at_home_at_rest():
    model = slider()
    angles, speeds = [], []
    arm, _ = arm_over(
        model,
        after_step=lambda: (angles.append(arm._controller.joints.copy()), speeds.append(arm._controller.speeds.copy())),
    )
    GuardedMove().attempt(arm, PATH)
    assert ((np.array(angles) > LOWER) & (np.array(angles) < UPPER)).all()
    assert (np.abs(speeds) < VELOCITY_LIMITS).all()
    assert np.abs(arm._controller.joints - HOME).max() < 0.01
    assert np.abs(arm._controller.speeds).max() < 0.05


def test_the_way_to_the_knob_and_back_touches_nothing():
    model = slider()
    touched = []
    arm, data = arm_over(model, after_step=lambda: touched.append(data.ncon))
    arm.reach(TOP - 0.05 * AXIS, AXIS)
    arm.home()
    assert not any(touched)


def test_noise_is_scaled_and_never_skipped():
    model, spread, states = slider(), [], []
    for noise in (0.0, 0.3):
        rng = np.random.default_rng(5)
        arm = SimulatedArm(model, mujoco.MjData(model), force_noise=noise, rng=rng)
        arm.stand()
        arm.reach(TOP - 0.05 * AXIS, AXIS)
        forces = []
        for _ in range(120):
            arm.follow(TOP - 0.05 * AXIS, np.zeros(3), stiffness=1500.0)
            forces.append(arm.force())
        spread.append(np.std(forces[40:], axis=0))
        states.append(rng.bit_generator.state)
    assert states[0] == states[1]
    assert (spread[0] < 0.01).all()
    assert spread[1] == pytest.approx(np.full(3, 0.3), rel=0.25)


def test_luck_that_it_takes_is_what_it_feels_from_then_on():
    model, forces = slider(), []
    for seed in (5, 6):
        arm = SimulatedArm(model, mujoco.MjData(model), force_noise=0.3, rng=np.random.default_rng(seed))
        arm.stand()
        for _ in range(3 * seed):
            arm.follow(TOP - 0.05 * AXIS, np.zeros(3), stiffness=0.0)
        arm.use_stream(np.random.default_rng(8))
        arm._read(np.zeros(3))
        forces.append(arm.force().tolist())
    assert forces[0] == forces[1] == (0.3 * np.random.default_rng(8).standard_normal(3)).tolist()


def test_the_same_seed_gives_the_same_course_bit_by_bit():
    courses = []
    for _ in range(2):
        arm, data = arm_over(slider(), force_noise=0.3)
        touch = GuardedMove().attempt(arm, PATH)
        courses.append((touch, data.qpos.tobytes(), data.qvel.tobytes()))
    assert courses[0] == courses[1]


def test_what_is_out_of_reach_breaks_the_trial_with_the_place():
    arm, _ = arm_over(slider())
    assert not arm.reaches(np.array([1.2, 0, 0.2]), AXIS)
    with pytest.raises(PlantFault, match=r"1\.2"):
        arm.reach(np.array([1.2, 0, 0.2]), AXIS)
