"""A lockbox as a plain MuJoCo model."""

import subprocess
import sys
from dataclasses import replace

import lockprobe_robot
import mujoco
import numpy as np
import pytest
from lockprobe_robot.box_model.mjcf import write_model

from lockprobe.boxes.box import Joint, Lockbox
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadValue

TRAVEL_OF_PUSH = 0.4
"""Seconds of pushing, and as many of coming to rest."""


def test_the_file_alone_holds_the_interlock(tmp_path):
    """Whoever loads it and pushes joints finds the rules of the box, without a line of ours."""
    lockbox = replace(box("chain-4"), initial=(False, True, False, False))
    write_model(lockbox, tmp_path / "box.xml")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "box.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("initial").id)
    configuration = lockbox.initial
    rng = np.random.default_rng(4)
    seen = set()
    for joint in rng.integers(len(lockbox.joints), size=30).tolist():
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


def test_with_the_arm_plain_mujoco_loads_it_without_a_warning_and_it_rests(tmp_path):
    write_model(box(), tmp_path / "scene.xml", arm=True)
    code = """
import sys, mujoco, numpy as np
model = mujoco.MjModel.from_xml_path(sys.argv[1])
data = mujoco.MjData(model)
mujoco.mj_resetDataKeyframe(model, data, model.key("initial").id)
began = data.qpos.copy()
mujoco.mj_step(model, data, 300)
assert abs(data.qpos - began).max() < 0.02, abs(data.qpos - began).max()
assert not any(warning.number for warning in data.warning)
assert {model.camera(i).name for i in range(model.ncam)} >= {"lockprobe", "oblique"}
assert (model.nu, abs(data.sensor("force").data).max() > 1) == (7, True)
assert "lockprobe" not in sys.modules
"""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-I", "-c", code, tmp_path / "scene.xml"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert not (tmp_path / "MUJOCO_LOG.TXT").exists()


@pytest.mark.parametrize("arm", [False, True])
def test_in_python_it_is_a_model_and_a_state_at_the_start_of_a_trial(arm):
    lockbox = replace(box("chain-4"), initial=(False, True, False, False))
    model, data = lockprobe_robot.scene(lockbox, arm=arm)
    places = [data.joint(name).qpos[0] > np.mean(model.joint(name).range) for name in lockbox.names]
    assert tuple(map(bool, places)) == lockbox.initial
    assert model.nu == (7 if arm else 0)


def test_a_joint_with_the_name_of_a_hidden_part_is_refused(tmp_path):
    places = {"door": (0.2, 0.5), "bolt-0": (0.8, 0.5)}
    joints = tuple(Joint(name=name, kind="revolute", place=place) for name, place in places.items())
    named = Lockbox(name="odd", joints=joints, interlock={}, initial=(False, False), target="door")
    with pytest.raises(BadValue, match="joint: got 'bolt-0', expected another name: a hidden part of the model has"):
        write_model(named, tmp_path / "box.xml")
    assert list(tmp_path.iterdir()) == []
