"""A lockbox as an MJCF file."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from lockprobe_robot.scene.mjcf import write_mjcf

from lockprobe.boxes.box import Joint, Lockbox
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadFile, BadValue

TRAVEL_OF_PUSH = 0.4
"""Seconds of pushing, and as many of coming to rest."""


@pytest.mark.parametrize("name", ["chain-4", "common-cause-3"])
def test_the_file_alone_holds_the_interlock(tmp_path, name):
    """Whoever loads it and pushes joints finds the rules of the box, without a line of ours."""
    lockbox = replace(box(name), initial=(False, True, *box(name).initial[2:]))
    write_mjcf(lockbox, tmp_path / "box.xml", labels=tuple("ABCDEFGH"[: len(lockbox.joints)]))
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "box.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("initial").id)
    configuration = lockbox.initial
    rng = np.random.default_rng(4)
    seen = set()
    for joint in rng.integers(len(lockbox.joints), size=30).tolist():
        low, high = model.joint(lockbox.names[joint]).range
        revolute = model.joint(lockbox.names[joint]).type[0] == mujoco.mjtJoint.mjJNT_HINGE
        force = (1.5 if revolute else 30.0) * (-1 if configuration[joint] else 1)
        for applied in (force, 0.0):
            data.qfrc_applied[model.joint(lockbox.names[joint]).dofadr[0]] = applied
            mujoco.mj_step(model, data, round(TRAVEL_OF_PUSH / model.opt.timestep))
        configuration, moved = lockbox.attempt(configuration, joint)
        found = [data.joint(name).qpos[0] > np.mean(model.joint(name).range) for name in lockbox.names]
        assert tuple(map(bool, found)) == configuration
        seen.add(moved)
    assert seen == {True, False}
    assert low < high


def test_its_surfaces_lie_beside_it(tmp_path):
    write_mjcf(box(), tmp_path / "box.xml", labels=tuple("ABCD"))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["box-board.png", "box-case.png", "box.xml"]


def test_joints_may_have_the_names_that_parts_of_the_scene_have(tmp_path):
    write_mjcf(box("random-3-4"), tmp_path / "box.xml", labels=tuple("ABC"))
    known, model = box("random-3-4"), mujoco.MjModel.from_xml_path(str(tmp_path / "box.xml"))
    assert "knob-1" in known.names
    for number, name in enumerate(known.names):
        assert model.joint(name).bodyid == model.body(f"part-{number}").id
        assert model.site(name).bodyid == model.body(f"part-{number}").id


def test_a_joint_with_the_name_of_a_hidden_part_is_refused(tmp_path):
    named = Lockbox(
        name="odd", joints=(Joint(name="door", kind="revolute", place=(0.2, 0.5)), Joint(name="bolt-0", kind="prismatic", place=(0.8, 0.5))),
        interlock={"door": ({"bolt-0": True},)}, initial=(False, False), target="door",
    )  # fmt: skip
    with pytest.raises(
        BadValue, match="joint: got 'bolt-0', expected another name: a hidden part of the model has this"
    ):
        write_mjcf(named, tmp_path / "box.xml", labels=("A", "B"))
    assert list(tmp_path.iterdir()) == []


def test_a_place_that_cannot_be_written_is_refused(tmp_path):
    with pytest.raises(BadFile, match="cannot be written"):
        write_mjcf(box(), tmp_path / "nowhere" / "box.xml", labels=tuple("ABCD"))
