"""The twin: truth and what the robot makes of it, on the box that ships."""

from types import SimpleNamespace

import mujoco
import numpy as np
import pytest
from lockprobe_robot.arm.guarded_move import GuardedMove, Touch
from lockprobe_robot.arm.simulated_arm import SimulatedArm
from lockprobe_robot.fast_twin import FastTwin
from lockprobe_robot.twin import Twin
from lockprobe_robot.twin_settings import SceneSettings, TwinSettings

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadValue, PlantFault
from lockprobe.trial.protocols import Plant

CHAIN = box("chain-4")
TARGET, FIRST, SECOND, FREE = range(4)


def twin(seed=1, film=None, **settings):
    return Twin(
        CHAIN,
        labels=("A", "B", "C", "D"),
        settings=TwinSettings(**settings),
        rng=np.random.default_rng(seed),
        film=film,
    )


def test_it_is_a_plant_and_shows_the_configuration_at_the_start():
    plant = twin()
    assert isinstance(plant, Plant)
    assert plant.observe().configuration == CHAIN.initial
    assert plant.observe().outcome is None
    assert plant.facts["engine"] == f"mujoco {mujoco.__version__}"
    assert plant.facts["renderer"] is None


@pytest.fixture(scope="module")
def solution():
    """A filmed solution with locked joints between: its snapshots, the film's times, and the contacts of the arm."""
    times, touching, deepest = [], set(), []

    def look(model, data):
        times.append(data.time)
        for contact in data.contact:
            names = [model.body(model.geom_bodyid[geom]).name for geom in (contact.geom1, contact.geom2)]
            if any(name.startswith(("link", "hand", "plate")) for name in names):
                touching.add(tuple(sorted(name.rstrip("0123456789") for name in names)))
                deepest.append(-contact.dist)

    plant = twin(film=look)
    snapshots = [plant.attempt(joint) for joint in (TARGET, FREE, SECOND, FREE, FIRST, TARGET)]
    return SimpleNamespace(snapshots=snapshots, plant=plant, times=times, touching=touching, deepest=deepest)


def assert_as_ruled(snapshots, joints):
    configuration = CHAIN.initial
    for joint, snapshot in zip(joints, snapshots, strict=True):
        configuration, moved = CHAIN.attempt(configuration, joint)
        assert snapshot.configuration == configuration
        assert snapshot.joint == joint
        assert snapshot.outcome == snapshot.sensed["verdict"] == ("moved" if moved else "blocked")
        assert 2 < snapshot.sensed["seconds"] < 6.2


def test_a_whole_solution_with_locked_joints_between_is_as_the_rules_have_it(solution):
    assert_as_ruled(solution.snapshots, (TARGET, FREE, SECOND, FREE, FIRST, TARGET))


def test_with_an_ideal_mechanism_attempts_are_as_the_rules_have_them():
    plant, joints = twin(mechanism="ideal"), (TARGET, FREE)
    assert_as_ruled([plant.attempt(joint) for joint in joints], joints)


def test_what_a_locked_joint_feels_like_is_not_what_a_free_one_does(solution):
    blocked, moved = (snapshot.sensed for snapshot in solution.snapshots[:2])
    assert moved["peak_force"] < 5
    assert 10 < blocked["peak_force"] < 12
    assert blocked["progress"] < 0.5
    assert moved["progress"] >= 1


def test_with_noise_the_robot_still_judges_right():
    plant = twin(pose_error=0.004, force_noise=0.3)
    for joint, outcome in ((FIRST, "blocked"), (FREE, "moved"), (SECOND, "moved")):
        snapshot = plant.attempt(joint)
        assert (snapshot.outcome, snapshot.sensed["verdict"]) == (outcome, outcome)


def test_a_hand_that_misses_the_handle_believes_that_it_moved_and_truth_and_belief_part():
    plant = twin(pose_error=0.03)
    snapshot = plant.attempt(FREE)
    assert snapshot.outcome == "blocked"
    assert snapshot.configuration == CHAIN.initial
    assert snapshot.sensed["verdict"] == "moved"


def test_the_same_seed_gives_the_same_trial_bit_by_bit():
    def course(seed, joints=(FREE, TARGET)):
        plant = twin(seed, pose_error=0.004, force_noise=0.3)
        snapshots = [plant.attempt(joint) for joint in joints]
        return [dict(s.sensed) for s in snapshots], plant._data.qpos.tobytes()

    first = course(3)
    assert first == course(3)
    assert first[0][0] != course(4, (FREE,))[0][0]


def test_what_makes_pictures_hard_changes_nothing_that_the_arm_does():
    hard = {
        "board": "bare", "labels": False, "handle_colours": "plain", "light": "dim", "colours": "second", "viewpoint": "oblique",
        "handle_shape": "square", "clutter": 9, "view_jitter": 5.0, "view_turn": 1.0,
    }  # fmt: skip
    courses = []
    for options in ({}, hard):
        plant = twin(pose_error=0.004, force_noise=0.3, **options)
        courses.append((dict(plant.attempt(FREE).sensed), plant._data.qpos.tobytes()))
    assert courses[0] == courses[1]


@pytest.mark.parametrize("tilt", [0, 75])
def test_an_arm_at_home_hides_nothing_of_the_board_from_the_oblique_camera(tilt):
    options = {"tilt": tilt, "viewpoint": "oblique", "width": 128, "height": 96}
    alone = (
        FastTwin(CHAIN, labels=tuple("ABCD"), settings=SceneSettings(**options), rng=np.random.default_rng(1))
        .observe()
        .look()
    )
    seen = twin(**options).observe().look()
    board = alone.camera.heights(alone.depth) > -0.002
    assert board.mean() > 0.1
    assert (alone.depth - seen.depth)[board].max() < 0.02


def test_luck_does_not_depend_on_how_much_of_it_there_is():
    """Where the robot errs is the same direction whatever the scale, so that conditions are compared on the same luck."""
    shifts = []
    for error in (0.001, 0.002):
        plant = twin(pose_error=error)
        path, believed = plant._panel.handle_path(FREE, False), plant._believed_path(FREE, False)
        shifts.append((believed.points - path.points)[0] / error)
        assert plant._aim.bit_generator.state == twin_after_one_draw()
    assert np.allclose(shifts[0], shifts[1])


def twin_after_one_draw():
    plant = twin(pose_error=0.0)
    plant._believed_path(FREE, False)
    return plant._aim.bit_generator.state


def test_luck_of_an_attempt_does_not_depend_on_how_long_the_one_before_took(monkeypatch):
    """A hand that misses a locked handle goes on, so that more forces are read in its first attempt."""
    ways = [{}, {"pose_error": 0.004}, {"pose_error": 0.03}]
    plants = [twin(force_noise=0.3, **settings) for settings in ways]
    seconds = [plant.attempt(TARGET).sensed["seconds"] for plant in plants]
    assert len(set(seconds)) > 1
    noises = []

    def feel_nothing(self, arm, path):
        arm._read(np.zeros(3))
        noises.append(arm.force().tolist())
        return Touch(verdict="blocked", peak_force=0.0, progress=0.0, seconds=1.0)

    monkeypatch.setattr(GuardedMove, "attempt", feel_nothing)
    for plant in plants:
        plant.attempt(FIRST)
        plant.attempt(FIRST)
    second, third = noises[::2], noises[1::2]
    assert second == [second[0]] * 3
    assert third == [third[0]] * 3
    assert second[0] != third[0]


def test_a_handle_out_of_reach_is_refused_by_the_name_of_the_setting(monkeypatch):
    monkeypatch.setattr(SimulatedArm, "reaches", lambda self, position, axis: False)
    with pytest.raises(BadValue, match="tilt: got 20.0"):
        twin()


@pytest.mark.parametrize(("left", "outcome"), [(0.45, "blocked"), (0.55, "moved")])
def test_a_joint_left_between_its_ends_is_pushed_to_the_nearer_one(monkeypatch, left, outcome):
    plant = twin()

    def leave_it(self, arm, path):
        plant._data.joint("joint-3").qpos[0] = left * plant._panel.mounted_joints[FREE].travel
        return Touch(verdict="failed", peak_force=0.0, progress=0.5, seconds=1.0)

    monkeypatch.setattr(GuardedMove, "attempt", leave_it)
    monkeypatch.setattr("lockprobe_robot.twin._PATIENCE", 0.02)
    seen = plant.attempt(FREE)
    assert (seen.outcome, seen.sensed["nudged"], seen.sensed["verdict"]) == (outcome, True, "failed")


def test_another_joint_that_moves_breaks_the_trial(monkeypatch):
    plant = twin()

    def move_another(self, arm, path):
        plant._data.joint("joint-3").qpos[0] = plant._panel.mounted_joints[FREE].travel
        return Touch(verdict="blocked", peak_force=12.0, progress=0.1, seconds=1.0)

    monkeypatch.setattr(GuardedMove, "attempt", move_another)
    with pytest.raises(PlantFault, match="another joint moved with joint 1: 0000 became 0001"):
        plant.attempt(FIRST)


def test_a_film_has_25_pictures_in_a_simulated_second_and_changes_nothing(solution):
    times = solution.times
    assert solution.snapshots[0].sensed == twin().attempt(TARGET).sensed
    assert np.diff(times) == pytest.approx(np.full(len(times) - 1, 0.04), abs=0.0021)
    assert len(times) == pytest.approx(25 * solution.plant.data.time, abs=2)


def test_only_the_ring_touches_and_only_the_handle_and_nothing_goes_into_anything(solution):
    assert solution.touching == {("part-", "plate")}
    assert max(solution.deepest) < 0.0015
