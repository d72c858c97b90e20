"""The twin: truth and what the robot makes of it, on the box that ships."""

from contextlib import closing
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest
from drawn_board import heights_at
from lockprobe_robot import twin as module
from lockprobe_robot.arm.guarded_move import Touch
from lockprobe_robot.arm.model import VELOCITY_LIMITS
from lockprobe_robot.arm.simulated_arm import SimulatedArm
from lockprobe_robot.fast_twin import FastTwin
from lockprobe_robot.twin import Twin
from lockprobe_robot.twin_settings import SceneSettings, TwinSettings
from mjcf_models import EXAMPLES, written

from lockprobe import run_trial
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.testing import ScriptedAgent, check_plant
from lockprobe.trial.protocols import Plant

CHAIN = box("chain-4")
LABELS = tuple("ABCD")
TARGET, FIRST, SECOND, FREE = range(4)
HAND = EXAMPLES / "own_hand.xml"
LOOKS = {"board": "bare", "labels": False, "discs": False, "light": "side", "colours": "second", "looks": "varied"}
LOOKS |= {"viewpoint": "oblique", "handle_colours": "plain", "clutter": 9, "view_jitter": 5.0}


def twin(seed=1, film=None, **settings):
    rng = np.random.default_rng(seed)
    return Twin(CHAIN, labels=LABELS, settings=TwinSettings(**settings), rng=rng, film=film)


def moving(move):
    """In the place of the guarded move: what it does, and what the robot believes."""

    def instead(arm, path):
        verdict = move(arm, path)
        return Touch(verdict=verdict, peak_force=0.0, progress=0.5, seconds=1.0)

    return instead


@pytest.fixture(scope="module")
def solution():
    """A filmed solution with locked joints between: its snapshots, and the speeds and contacts of the arm."""
    speeds, touching, deepest = [], set(), []

    def look(model, data):
        speeds.append(data.qvel[model.joint("arm-1").dofadr[0] :][:7].copy())
        for contact in data.contact:
            names = [model.body(model.geom_bodyid[geom]).name for geom in (contact.geom1, contact.geom2)]
            if any(name.startswith(("arm-", "hand")) for name in names):
                touching.add(tuple(sorted(name.rstrip("0123456789") for name in names)))
                deepest.append(-contact.dist)

    plant = twin(film=look)
    snapshots = [plant.attempt(joint) for joint in (TARGET, FREE, SECOND, FREE, FIRST, TARGET)]
    return SimpleNamespace(snapshots=snapshots, plant=plant, speeds=speeds, touching=touching, deepest=deepest)


def test_a_whole_solution_with_locked_joints_between_is_as_the_rules_have_it(solution):
    assert isinstance(solution.plant, Plant)
    configuration = CHAIN.initial
    for joint, snapshot in zip((TARGET, FREE, SECOND, FREE, FIRST, TARGET), solution.snapshots, strict=True):
        configuration, moved = CHAIN.attempt(configuration, joint)
        assert (snapshot.configuration, snapshot.joint) == (configuration, joint)
        assert snapshot.outcome == snapshot.sensed["verdict"] == ("moved" if moved else "blocked")
        assert 2 < snapshot.sensed["seconds"] < 6.2
        assert (snapshot.sensed["peak_force"] < 5.1) if moved else (10 < snapshot.sensed["peak_force"] < 12)
        assert (snapshot.sensed["progress"] >= 1) == moved
    assert solution.plant.facts["engine"] == f"mujoco {mujoco.__version__}"
    assert solution.plant.facts["renderer"] is None


def test_only_the_ring_touches_and_only_the_handle_and_nothing_goes_into_anything(solution):
    assert solution.touching == {("hand-plate", "part-")}
    assert max(solution.deepest) < 0.0015
    assert (np.abs(solution.speeds) < VELOCITY_LIMITS).all()


def test_with_noise_the_robot_still_judges_right_and_one_seed_is_one_course_bit_by_bit():
    """Whatever makes pictures hard, too, which changes nothing that the arm does."""
    courses = []
    for seed, options in ((1, {}), (1, LOOKS), (2, {})):
        plant = twin(seed, pose_error=0.004, force_noise=0.3, **options)
        course = []
        for joint, outcome in ((FIRST, "blocked"), (FREE, "moved")):
            snapshot = plant.attempt(joint)
            assert (snapshot.outcome, snapshot.sensed["verdict"]) == (outcome, outcome)
            course.append(dict(snapshot.sensed))
        courses.append(course)
    assert courses[0] == courses[1] != courses[2]


def test_luck_does_not_depend_on_how_much_of_it_there_is(monkeypatch):
    """Where the robot errs is the same direction whatever the scale, and noise does not depend on the attempt before."""
    shifts, noises = [], []

    def note(arm, path):
        shifts.append(path.points[0])
        arm._read(np.zeros(3))
        noises.append(arm.force().tolist())
        for _ in shifts:  # each attempt takes longer than the one before
            arm._read(np.zeros(3))
        return "blocked"

    monkeypatch.setattr(module, "guarded_move", moving(note))
    for error in (0.0, 0.001, 0.002):
        plant = twin(pose_error=error, force_noise=0.3)
        plant.attempt(FIRST)
        plant.attempt(FIRST)
    zero, small, large = shifts[::2]
    assert large - zero == pytest.approx(2 * (small - zero))
    assert noises[:2] == noises[2:4] == noises[4:]
    assert noises[0] != noises[1]


def fast_twin(**settings):
    return FastTwin(CHAIN, labels=LABELS, settings=SceneSettings(**settings), rng=np.random.default_rng(1))


def test_the_fast_twin_obeys_the_rules_and_who_does_not_look_has_the_same_luck():
    check_plant("fast-twin?width=64&height=64", boxes=["random-5-2"], attempts=12)
    looked, blind = (fast_twin(width=64, height=64, depth_noise=0.002, view_jitter=5.0) for _ in range(2))
    looked.observe().look()
    for joint in (3, 2, 1):
        seen = looked.attempt(joint)
        assert seen == blind.attempt(joint)
        seen.look()
        seen.render((True,) * 4)
    assert (looked.joints.fractions() == blind.joints.fractions()).all()
    looked.close()


def test_every_option_of_looks_is_seen():
    def seen(**settings):
        with closing(fast_twin(width=160, height=120, **settings)) as plant:
            return plant.observe().look().rgb

    plain = seen()
    assert [name for name, value in LOOKS.items() if (seen(**{name: value}) == plain).all()] == []


def test_an_arm_at_home_hides_nothing_of_the_board_from_the_oblique_camera():
    options = {"tilt": 75, "viewpoint": "oblique", "width": 128, "height": 96}
    seen, plain = (plant.observe().look() for plant in (twin(**options), fast_twin(**options)))
    board = heights_at(plain.camera, plain.depth) > -0.002
    assert board.mean() > 0.1
    assert (plain.depth - seen.depth)[board].max() < 0.02


def test_a_handle_out_of_reach_is_refused_by_the_name_of_the_setting(monkeypatch):
    monkeypatch.setattr(SimulatedArm, "reaches", lambda self, position, axis: False)
    with pytest.raises(BadValue, match="tilt: got 20.0"):
        twin()


@pytest.mark.parametrize(("left", "outcome"), [(0.45, "blocked"), (0.55, "moved")])
def test_a_joint_left_between_its_ends_is_pushed_to_the_nearer_one(monkeypatch, left, outcome):
    plant = twin()

    def leave_it(arm, path):
        plant.joints.data.joint("revolute-right").qpos[0] = left * plant.panel.mounted_joints[FREE].travel
        return "failed"

    monkeypatch.setattr(module, "guarded_move", moving(leave_it))
    monkeypatch.setattr(module, "_PATIENCE", 0.02)
    seen = plant.attempt(FREE)
    assert (seen.outcome, seen.sensed["nudged"], seen.sensed["verdict"]) == (outcome, True, "failed")


def test_ones_own_hand_moves_a_free_joint_feels_a_locked_one_and_is_named_by_its_digest(tmp_path):
    plant = twin(hand=str(HAND))
    blocked, moved = plant.attempt(FIRST), plant.attempt(FREE)
    assert (blocked.outcome, blocked.sensed["verdict"]) == ("blocked", "blocked")
    assert (moved.outcome, moved.sensed["verdict"]) == ("moved", "moved")
    assert moved.sensed["peak_force"] < 10 < blocked.sensed["peak_force"]
    spec = resolve_plant(f"twin?hand={HAND}").spec
    assert "hand_digest=" in spec
    assert resolve_plant(spec).spec == spec
    with pytest.raises(BadFile, match="another model: its digest is"):
        twin(hand=str(HAND), hand_digest="0" * 16)
    path = written(tmp_path, "<mujoco><worldbody><body><geom size='.01'/></body></worldbody></mujoco>")
    with pytest.raises(BadFile, match="no site 'tool' in a body, which is where the hand holds the top of a knob$"):
        twin(hand=str(path))


def test_a_hand_that_misses_believes_that_it_moved_whether_the_plant_or_a_condition_errs():
    """Truth and belief part; the same luck, and the same step."""
    short = {"agent": ScriptedAgent(joints=(FREE,)), "shuffle": "never", "max_steps": 1, "seed": 3}
    plain = run_trial(plant="twin?pose_error=0.03", **short)
    missing = run_trial(plant="twin", condition="plant?pose_error=0.03", **short)
    assert missing.steps == plain.steps
    assert (missing.plant, missing.doses) == (plain.plant, {"plant.pose_error": 0.03})
    assert (plain.steps[0].moved, plain.steps[0].sensed["verdict"]) == (False, "moved")
