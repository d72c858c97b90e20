"""The bundled arm on a user's model: it plays by the rules where it reaches, else one line says how far it is off."""

import mujoco
import numpy as np
import pytest
from lockprobe_robot.twin_settings import UserModelSettings
from lockprobe_robot.user_model.arm_on_model import Reach
from lockprobe_robot.user_model.user_model import UserModel, check_model
from mjcf_models import OWN, exported, own_box, written

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadFile
from lockprobe.plants.catalogue import resolve_plant

DOWN = np.array([0.0, 0.0, -1.0])
SIZE = 'size="0.015 0.02"'


def our_own(folder, name="chain-3", arm=""):
    """Our own scene of a box as a user's model, with what is added to the world."""
    path = exported(box(name), folder)
    path.write_text(path.read_text("utf-8").replace("<worldbody>", f"<worldbody>{arm}", 1), "utf-8")
    return path, box(name)


def own_with(folder, old, new):
    """The example, changed."""
    text = OWN.read_text("utf-8")
    assert old in text
    return written(folder, text.replace(old, new))


def plant(path, puzzle, **settings):
    settings = UserModelSettings(model=str(path), arm=True, renderer="rays", width=160, height=120, **settings)
    return UserModel(puzzle, labels=puzzle.names, settings=settings, rng=np.random.default_rng(0))


def refused(path, puzzle):
    with pytest.raises(BadFile) as error:
        check_model(puzzle, UserModelSettings(model=str(path), arm=True))
    assert "\n" not in str(error.value)
    return str(error.value).removeprefix(f"{path}: ")


def plays_by_the_rules(physical, puzzle, attempts, seed=3):
    now, rng = puzzle.initial, np.random.default_rng(seed)
    others = [joint for joint, name in enumerate(puzzle.names) if name != puzzle.target]
    for _ in range(attempts):
        joint = int(rng.choice(others))
        expected = "moved" if puzzle.may_move(now, joint) else "blocked"
        now, _ = puzzle.attempt(now, joint)
        seen = physical.attempt(joint)
        assert (seen.configuration, seen.outcome, seen.sensed["verdict"]) == (now, expected, expected)
    return now


def test_it_drags_the_handles_of_a_model_by_the_rules(tmp_path):
    path, puzzle = our_own(tmp_path)
    assert check_model(puzzle, UserModelSettings(model=str(path), arm=True)) == 4
    physical = plant(path, puzzle)
    plays_by_the_rules(physical, puzzle, 8)
    assert physical.facts["mechanism"] == "a user's model, dragged by an arm"
    assert physical.facts["arm_base"] == "0.015 -0.000 0.011"


def test_parts_that_lock_by_their_shapes_and_rest_by_friction_alone():
    assert check_model(own_box(), UserModelSettings(model=str(OWN), arm=True)) == 3
    plays_by_the_rules(plant(OWN, own_box()), own_box(), 8)


def test_a_site_says_where_the_base_stands(tmp_path):
    path, puzzle = our_own(tmp_path, arm='<site name="arm" pos="1 0.05 0" xyaxes="-1 0 0 0 -1 0"/>')
    physical = plant(path, puzzle)  # from the other side
    assert physical.facts["arm_base"] == "1.000 0.050 0.000"
    plays_by_the_rules(physical, puzzle, 4)


def test_what_is_out_of_reach_is_one_line_with_metres(tmp_path):
    path, puzzle = our_own(tmp_path, arm='<site name="arm" pos="-0.6 0 0"/>')
    said = refused(path, puzzle)
    assert said.startswith("the arm does not reach revolute-left (0.2")
    assert said.count("m out of reach") == 3
    assert said.endswith(": its base stands at -0.600 0.000 0.000 m; a site 'arm' in the model puts it elsewhere")


@pytest.mark.parametrize(
    ("point", "least", "most"),
    [((0.5, 0, 0.2), 0, 0), ((1.2, 0.3, 0.2), 0.4, 0.7), ((0, 0, 2.5), 1.5, 2.2), ((0.05, 0, 0.1), 0.05, 0.4)],
)
def test_a_point_is_out_of_reach_by_about_the_shortest_way(point, least, most):
    reach = Reach(DOWN)
    far = reach.short_of(np.array(point))
    assert least <= far <= most
    ways = np.random.default_rng(1).standard_normal((60, 3))
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    assert far == 0 or not any(reach.has(point + 0.7 * far * way) for way in ways)


def test_the_distance_is_that_of_a_box_moved_so_far(tmp_path):
    reach, point = Reach(DOWN), np.array([1.0, 0.0, 0.25])
    far = reach.short_of(point)
    assert reach.has(point - [far, 0, 0])
    assert not reach.has(point - [far - 0.02, 0, 0])


def test_a_hand_that_cannot_point_that_way_has_no_distance(monkeypatch):
    monkeypatch.setattr(Reach, "has", lambda self, point: False)
    assert Reach(DOWN).short_of(np.array([0.5, 0, 0.2])) == float("inf")


def test_a_handle_that_the_hand_does_not_hold_is_one_line(tmp_path):
    said = refused(own_with(tmp_path, SIZE, f'{SIZE} contype="0" conaffinity="0"'), own_box())
    assert said.startswith(
        "in configuration 000 (door, bar, pin), door was pushed: the model held it, and the arm judged "
    )
    assert said.endswith("of contype 1, with 5 cm of room")


def test_handles_too_close_for_the_hand_are_one_line(tmp_path):
    path = own_with(tmp_path, '"0 0.05 0.', '"0 -0.045 0.')
    assert refused(path, own_box()).startswith(
        "in configuration 001 (door, bar, pin), bar was pushed: the rules let it "
    )


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ('<site name="pin" pos', '<site name="pine" pos', "got 'no site of its name', expected one in the middle"),
        ('<body name="panel"', '<site name="bar"/><body name="panel"', "a site that does not move with its joint"),
        ('timestep="0.002"', 'timestep="0.004"', "a time step of 0.004 s, expected at most 0.002 s with an arm"),
        ('name="panel"', 'name="link3"', "link3"),
    ],
)
def test_a_model_that_cannot_have_an_arm_is_one_line(tmp_path, old, new, why):
    text = OWN.read_text("utf-8")
    if "bar" in new:
        text = text.replace('<site name="bar" pos', '<site name="rod" pos')
    assert why in refused(written(tmp_path, text.replace(old, new)), own_box())


def test_defaults_and_keyframes_of_the_model_stay_with_the_model(tmp_path):
    key = '<keyframe><key name="initial" qpos="0 0.08 0.08"/></keyframe></mujoco>'
    path = written(tmp_path, OWN.read_text("utf-8").replace("</mujoco>", key))
    model = plant(path, own_box())._joints.model
    assert model.joint("bar").damping[0] == 8
    assert model.joint("arm-1").damping[0] == 0.5
    assert model.dof_frictionloss[model.joint("arm-1").dofadr[0]] == 0
    assert model.body("link3").mass[0] == pytest.approx(3.228604)
    assert model.key("initial").qpos[:3] == pytest.approx([0, 0.08, 0.08])
    assert mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, "label-bar") >= 0


def test_a_spec_leads_to_it(tmp_path):
    path, _ = our_own(tmp_path)
    armed, bare = resolve_plant(f"twin?model={path}&arm=yes"), resolve_plant(f"twin?model={path}")
    assert (armed.has_arm, bare.has_arm) == (True, False)
    assert armed.make_filmed is not None
    assert bare.make_filmed is None


def test_a_film_sees_the_arm_25_times_a_second_through_a_camera_at_its_side(tmp_path):
    seen = []
    settings = UserModelSettings(model=str(OWN), arm=True)
    filmed = UserModel(
        own_box(), labels=own_box().names, settings=settings, rng=np.random.default_rng(0),
        film=lambda model, data: seen.append((model, data.time, data.joint("pin").qpos[0])),
    )  # fmt: skip
    began = len(seen)
    seconds = filmed.attempt(2).sensed["seconds"]
    assert len(seen) - began == pytest.approx(25 * seconds, abs=8)
    assert any(0.02 < way < 0.06 for _, _, way in seen)  # the handle on its way
    model = seen[0][0]
    assert np.linalg.norm(model.camera("oblique").pos - model.body("link0").pos) == pytest.approx(1.88, abs=0.5)
    own = OWN.read_text("utf-8").replace("<light", '<camera name="oblique" pos="0 0 2"/><light')
    assert plant(written(tmp_path, own), own_box())._joints.model.camera("oblique").pos[2] == 2
