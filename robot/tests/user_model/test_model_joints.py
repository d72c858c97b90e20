"""Joints of a user's model: found by name, position 0 at the low end, moved by a push."""

import pytest
from lockprobe_robot.user_model.compiled_model import compile_model
from lockprobe_robot.user_model.mjcf_file import read_model
from lockprobe_robot.user_model.model_joints import ModelJoints
from mjcf_models import OWN, one_joint, own_box, written

from lockprobe.foundation.errors import BadValue, PlantFault


def joints_of(path, box, force=30.0, torque=1.8):
    return ModelJoints(compile_model(read_model(path)), box, force=force, torque=torque)


def test_position_0_is_the_low_end_and_a_push_leads_to_the_other(tmp_path):
    path = written(tmp_path)
    path.write_text(path.read_text("utf-8").replace('range="0 0.1"', 'range="-0.3 -0.1"'), "utf-8")
    joints = joints_of(path, one_joint())
    joints.start((False,))
    assert joints.data.qpos[0] == pytest.approx(-0.3, abs=1e-3)
    for position in (True, False):
        joints.push(0)
        assert (joints.configuration(), joints.resting()) == ((position,), True)
    joints.start((True,))
    assert joints.data.qpos[0] == pytest.approx(-0.1, abs=1e-3)


def test_a_push_that_is_too_weak_moves_nothing(tmp_path):
    path = written(tmp_path)
    for force, moves in ((0.5, False), (2.0, True)):  # against a friction of 1 N
        joints = joints_of(path, one_joint(), force=force)
        joints.start((False,))
        joints.push(0)
        assert (joints.configuration(), joints.resting()) == ((moves,), True)


def test_a_saved_state_comes_back_bit_by_bit():
    joints = joints_of(OWN, own_box())
    joints.start((False, False, False))
    before = joints.saved()
    joints.push(2)
    once = joints.saved()
    joints.restore(before)
    joints.push(2)
    assert joints.saved().tobytes() == once.tobytes()


def test_a_pose_leaves_the_state_alone():
    joints = joints_of(OWN, own_box())
    joints.start((False, False, False))
    before = joints.saved()
    posed = joints.posed((True, False, True))
    assert posed.qpos[:3] == pytest.approx([1.4, 0, 0.08], abs=1e-3)
    assert joints.saved().tobytes() == before.tobytes()


@pytest.mark.parametrize(
    ("old", "new", "kind", "why"),
    [
        ('name="bolt"', 'name="belt"', "prismatic", r"joints of the model: got \"'belt'\", expected one called 'bolt'"),
        ('type="slide"', 'type="hinge"', "prismatic", 'another type.*type="slide", since it is prismatic'),
        ('type="slide"', 'type="slide"', "revolute", 'another type.*type="hinge", since it is revolute'),
        ('range="0 0.1"', "", "prismatic", "got 'no range', expected a limited range"),
        (
            "</worldbody>",
            '<body><freejoint name="loose"/><geom size="1"/></body></worldbody>',
            "prismatic",
            "free joint",
        ),
        ("<joint", '<joint name="x" type="ball"/></body></worldbody></mujoco><!--', "prismatic", "expected one called"),
    ],
)
def test_joints_that_a_box_cannot_have_are_refused(tmp_path, old, new, kind, why):
    path = written(tmp_path)
    text = path.read_text("utf-8").replace(old, new)
    if "<!--" in new:
        text = text[: text.index("<!--")].replace("</body>", '<geom size=".1"/></body>')
    path.write_text(text, "utf-8")
    with pytest.raises(BadValue, match=why):
        joints_of(path, one_joint(kind))


def test_a_simulation_that_explodes_is_a_fault_and_writes_nothing(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    joints = joints_of(written(tmp_path, joint='stiffness="-1e13" springref="0.05"'), one_joint())
    with pytest.raises(PlantFault, match="became unstable"):
        joints.start((False,))
    assert capfd.readouterr() == ("", "")
    assert [path.name for path in tmp_path.iterdir()] == ["box.xml"]
