"""A user's model is held against the rules of its box by pushing."""

from dataclasses import replace

import pytest
from lockprobe_robot.twin_settings import UserModelSettings
from lockprobe_robot.user_model import rules_check
from lockprobe_robot.user_model.compiled_model import compile_model
from lockprobe_robot.user_model.mjcf_file import read_model
from lockprobe_robot.user_model.user_model import check_model
from mjcf_models import EXAMPLES, OWN, exported, one_joint, own_box, written

from lockprobe.boxes.box import Joint
from lockprobe.boxes.families import box
from lockprobe.boxes.solve import difficulty
from lockprobe.foundation.errors import BadFile


def check(path, puzzle, **settings):
    return check_model(puzzle, UserModelSettings(model=str(path), **settings))


def refused(path, puzzle, **settings):
    with pytest.raises(BadFile) as error:
        check(path, puzzle, **settings)
    assert "\n" not in str(error.value)
    return str(error.value).removeprefix(f"{path}: ")


@pytest.mark.parametrize("name", ["bichain-3", "gray-code", "common-effect-3"])
def test_our_own_scenes_read_back_as_users_models_obey_their_rules_everywhere(tmp_path, name):
    assert check(exported(box(name), tmp_path), box(name)) == difficulty(box(name)).reachable


def test_a_rule_changed_in_either_direction_is_found(tmp_path):
    path, same = exported(box("chain-3"), tmp_path), box("chain-3")
    target = same.target
    looser = replace(same, interlock={**same.interlock, target: ({},)})
    assert f"{target} was pushed: the rules let it move, and the model held {target}" in refused(path, looser)
    needed = {name: not value for name, value in same.interlock[target][0].items()}
    other = replace(same, interlock={**same.interlock, target: (needed,)})
    assert f"{target} was pushed: the rules " in refused(path, other)


def test_the_line_names_configuration_joint_rules_and_model():
    puzzle = own_box()
    locked = replace(puzzle, interlock={**puzzle.interlock, "pin": ({"bar": True},)})
    # nothing else can move at the start, so the rules say that the box cannot be opened at all
    assert refused(OWN, locked) == (
        "in configuration 000 (door, bar, pin), pin was pushed: the rules lock it, and the model moved pin "
        "(door 0.00, bar 0.00, pin 1.00)"
    )


def test_the_page_quotes_what_is_said():
    puzzle = own_box()
    said = refused(OWN, replace(puzzle, interlock={**puzzle.interlock, "pin": ({},)}))
    assert f"\nbox.xml: {said}\n" in (EXAMPLES.parent / "robot" / "docs" / "twin.md").read_text("utf-8")


def test_joints_that_move_together_stop_half_way_or_fall_back_are_found(tmp_path):
    second = "<body pos='0 1 0'><joint name='pin' type='slide' axis='1 0 0' range='0 0.1'/><geom size='.02'/></body>"
    equal = "<equality><joint joint1='bolt' joint2='pin' polycoef='0 1 0 0 0'/></equality></mujoco>"
    path = written(tmp_path, outside=second)
    path.write_text(path.read_text("utf-8").replace("</mujoco>", equal), "utf-8")
    two = replace(one_joint(), joints=(*one_joint().joints, Joint(name="pin", kind="prismatic")), initial=(False,) * 2)
    assert "bolt was pushed: the rules let it move, and the model moved pin as well" in refused(path, two)
    wall = "<geom type='box' size='.01 .1 .1' pos='.08 0 0'/>"
    said = refused(written(tmp_path, outside=wall), one_joint())
    assert "left a joint more than 8% of its travel from its ends (bolt 0." in said
    assert "less friction" in said
    back = written(tmp_path, joint='stiffness="100"')
    assert "the rules let it move, and the model held bolt" in refused(back, one_joint())
    falls = written(tmp_path, axis="0 0 -1")
    assert refused(falls, one_joint()).startswith("the model does not rest in the initial configuration 0: bolt 1.0")


def test_a_model_that_explodes_when_it_is_pushed_is_one_line(tmp_path):
    path = written(tmp_path, joint='stiffness="-1e13" springref="0.05"')
    assert "became unstable" in refused(path, one_joint())


def test_a_mesh_that_cannot_be_used_is_one_line_that_names_it(tmp_path, capfd):
    def with_mesh(file):
        head = f"<asset><mesh name='part' file='{file}' inertia='shell'/></asset>"
        return written(tmp_path, head=head, inside="<geom type='mesh' mesh='part'/>")

    flat = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 {}\nf 1 2 3\nf 2 4 3\nf 1 4 2\nf 1 3 4\n"
    (tmp_path / "flat.obj").write_text(flat.format(0))
    (tmp_path / "narrow.obj").write_text(flat.format(1e-9))
    (tmp_path / "torn.stl").write_bytes(bytes(90))
    assert "coplanar" in refused(with_mesh("flat.obj"), one_joint())
    assert "torn.stl" in refused(with_mesh("torn.stl"), one_joint())
    with_mesh("narrow.obj")
    compile_model(read_model(tmp_path / "box.xml"))
    assert "qhull precision warning" in capfd.readouterr().err
    assert check(tmp_path / "box.xml", one_joint(), force=1e4) == 1
    assert capfd.readouterr() == ("", "")


def test_of_many_configurations_it_tries_the_same_sample_every_time(tmp_path, monkeypatch):
    path, same = exported(box("gray-code"), tmp_path), box("gray-code")
    monkeypatch.setattr(rules_check, "MOST_CONFIGURATIONS", 5)
    asked = []
    push = rules_check._disagreement
    monkeypatch.setattr(rules_check, "_disagreement", lambda *given: asked.append(given[2:4]) or push(*given))
    assert [check(path, same), check(path, same)] == [5, 5]
    assert asked[:20] == asked[20:]
    assert len({configuration for configuration, _ in asked}) == 5
