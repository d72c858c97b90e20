"""Joints that the camera does not see are named, with the reason."""

import numpy as np
from lockprobe_robot.twin_settings import UserModelSettings
from lockprobe_robot.user_model.model_check import check_own_model
from lockprobe_robot.user_model.user_model import UserModel, load_joints
from lockprobe_robot.user_model.view_check import out_of_view
from mjcf_models import OWN, one_joint, own_box, written

LID = '<body name="lid" pos="{} 0 0.1"><geom type="box" size="{} 0.2 0.002" contype="0" conaffinity="0"/></body>'


def seen(tmp_path, *changes):
    text = OWN.read_text("utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    settings = UserModelSettings(model=str(written(tmp_path, text)), renderer="rays", width=320, height=240)
    puzzle = own_box()
    plant = UserModel(puzzle, labels=("", "", ""), settings=settings, rng=np.random.default_rng(0))
    joints = load_joints(puzzle, settings)
    joints.start(puzzle.initial)
    return out_of_view(puzzle, joints, plant.render)


def test_all_joints_of_the_example_are_seen(tmp_path):
    assert seen(tmp_path) == {}


def test_a_handle_outside_the_picture_at_an_end(tmp_path):
    found = seen(tmp_path, ('fovy="40"', 'fovy="12"'))
    assert found["door"] == "its handle is outside the picture at position 1"
    turned = seen(tmp_path, ('xyaxes="1 0 0 0 1 0"', 'xyaxes="-1 0 0 0 1 0"'))  # away from the board
    assert set(turned) == {"door", "bar", "pin"}


def test_a_joint_behind_a_part_is_hidden_by_its_name(tmp_path):
    found = seen(tmp_path, ("</worldbody>", LID.format(0.06, 0.14) + "</worldbody>"))
    assert found["pin"].startswith("hidden behind lid, its motion changes ")
    assert set(found) == {"bar", "pin"}


def test_a_joint_of_a_group_that_no_camera_shows_is_hidden(tmp_path):
    bare = '<geom type="box" size="0.015 0.064 0.01"/>'
    handle = '<geom class="handle" pos="0 0.05 0.03"/>'
    found = seen(tmp_path, (bare, bare.replace("<geom", '<geom group="4"')), (handle, ""))
    assert found == {"pin": "hidden behind panel, its motion changes 0 pixels"}


def test_a_model_without_a_camera_says_so(tmp_path):
    path = written(tmp_path)
    found = check_own_model(one_joint(), f"twin?model={path}&renderer=rays&width=160&height=120")
    assert found.view == "MuJoCo's default view, without a camera 'lockprobe'"


def test_the_check_of_a_model_draws_the_names_over_what_the_camera_sees():
    from lockprobe.trial.pictures.png import from_png

    found = check_own_model(own_box(), f"twin?model={OWN}&renderer=rays&width=320&height=240")
    assert (found.model, found.out_of_view, found.renderer.split()[0]) == (OWN, {}, "rays")
    assert found.view == "camera 'lockprobe'"
    assert from_png(found.picture).shape == (240, 320, 3)
    assert len(found.pushes) == 9
    assert not any(push.disagreement for push in found.pushes)
    assert found.dragged is None


def test_the_arm_drags_what_a_force_pushes_if_it_is_asked_for():
    found = check_own_model(own_box(), f"twin?model={OWN}&arm=yes&renderer=rays&width=160&height=120")
    assert [(made.configuration, made.joint, made.moved) for made in found.dragged] == [
        (made.configuration, made.joint, made.moved) for made in found.pushes
    ]


def test_the_spec_that_asks_for_the_arm(tmp_path):
    spec = f"twin?model={written(tmp_path)}&renderer=rays&width=160&height=120"
    assert check_own_model(one_joint(), f"{spec}&arm=no").with_arm == f"{spec}&arm=yes"
