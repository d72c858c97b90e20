"""The plant ``twin?model=FILE``: its truth is the symbolic one, its pictures are of the user's model."""

import hashlib
from dataclasses import replace

import numpy as np
import pytest
from builders import make_trial, write_study
from lockprobe_robot.twin_settings import UserModelSettings
from lockprobe_robot.user_model.user_model import UserModel
from mjcf_models import EXAMPLES, OWN, own_box, written

import lockprobe
from lockprobe.foundation.errors import BadFile, BadValue, PlantFault, SettingsChanged, UnknownName
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.studies.records.directory import claim
from lockprobe.trial.protocols import Plant

SPEC = f"twin?model={OWN}"
CALM = UserModelSettings(model=str(OWN), width=160, height=120)


def plant(puzzle=None, settings=CALM, labels=("A", "B", "C")):
    return UserModel(puzzle or own_box(), labels=labels, settings=settings, rng=np.random.default_rng(0))


def test_a_trial_of_the_example_is_the_symbolic_one_step_by_step():
    options = {"box": str(EXAMPLES / "own_box.toml"), "agent": "human-inspired", "p": 0.4, "seed": 5}
    pushed = lockprobe.run_trial(plant=f"{SPEC}", **options)
    ruled = lockprobe.run_trial(plant="symbolic", **options)
    assert pushed.steps == ruled.steps
    assert pushed.solved
    assert len(pushed.steps) > 3


def test_random_attempts_are_those_of_the_rules():
    puzzle = own_box()
    physical, symbolic = plant(puzzle), SymbolicPlant(puzzle)
    assert isinstance(physical, Plant)
    for joint in np.random.default_rng(1).integers(1, 3, size=12):  # not the door, whose motion ends a trial
        seen, ruled = physical.attempt(int(joint)), symbolic.attempt(int(joint))
        assert (seen.configuration, seen.joint, seen.outcome) == (ruled.configuration, ruled.joint, ruled.outcome)


def test_the_record_says_whose_model_it_is_and_which():
    facts = plant().facts
    assert facts["mechanism"] == "a user's model, pushed by a generalised force"
    assert facts["model_sha256"] == hashlib.sha256(OWN.read_bytes()).hexdigest()
    assert facts["model_parts_sha256"] is None
    assert (facts["force"], facts["torque"], facts["renderer"]) == (30.0, 1.8, None)


def test_pictures_show_the_moment_what_is_told_and_the_labels():
    physical = plant()
    before = physical.observe()
    first, told = before.look(), before.render((False, False, True))
    assert first.rgb.shape == (120, 160, 3)
    after = physical.attempt(2)
    second = after.look()
    assert (first.rgb != second.rgb).any()
    assert (np.abs(told.rgb.astype(int) - second.rgb) > 8).any(2).mean() < 0.002
    with pytest.raises(PlantFault, match="after the next attempt"):
        before.look()
    columns, rows = np.rint(first.camera.project(first.handles)[2, 0, :2]).astype(int)
    red, green, blue = first.rgb[rows, columns].astype(int)
    assert red > green + 60 > blue  # the handle of the pin
    bare = plant(labels=("", "", "")).observe().look()
    changed = (first.rgb != bare.rgb).any(2)
    assert 0 < changed.mean() < 0.05
    physical.close()


def test_heights_are_above_the_body_that_is_the_panel():
    frame = plant().observe().look()
    columns, rows = np.rint(frame.camera.project(frame.handles)[:, 0, :2]).astype(int).T
    assert frame.camera.heights(frame.depth)[rows, columns] == pytest.approx(0.062, abs=0.002)
    assert frame.camera.heights(frame.depth)[20:30, 80] == pytest.approx(0.0, abs=0.002)


def test_a_dealt_box_finds_its_joints_by_name():
    puzzle = own_box()
    dealt = replace(puzzle, joints=puzzle.joints[::-1])
    physical = plant(dealt)
    assert physical.attempt(0).outcome == "moved"
    assert physical.attempt(2).outcome == "blocked"


def test_its_panel_is_never_dealt_anew():
    """Else words would tell places where the joints of the model do not lie."""
    asked = {"plant": SPEC, "box": own_box(), "modality": "symbolic?places=yes"}
    planned = lockprobe.study("modalities", **asked)
    assert planned.layout == "fixed"
    assert all(plan.box == own_box() for agent in planned.agents for plan in planned.plans(agent))
    for layout in ("shuffled", "dealt"):
        with pytest.raises(BadValue, match=rf"^layout: got '{layout}', expected fixed with twin\?model=.*stay where"):
            lockprobe.study("modalities", layout=layout, **asked)


def test_a_spec_leads_to_it_with_options_of_its_own():
    source = resolve_plant(f"{SPEC}&force=20&width=320")
    assert source.has_camera
    assert source.picture_size == (320, 480)
    assert "force=20" in source.spec
    with pytest.raises(UnknownName, match=r"option of twin\?model is called 'pose_error'"):
        resolve_plant(f"{SPEC}&pose_error=0.004")
    with pytest.raises(BadValue, match="expected an MJCF file"):
        resolve_plant("twin?model=")


def test_a_study_does_not_go_on_with_another_model(tmp_path):
    options = {"agent": "random", "box": str(EXAMPLES / "own_box.toml"), "repetitions": 1, "trials": 1, "p": [0.0]}
    path = written(tmp_path, OWN.read_text("utf-8"))
    planned = lockprobe.study("flips", plant=f"twin?model={path}", **options)
    write_study(tmp_path / "S", planned, [make_trial([0], study="flips")])
    claim(tmp_path / "S", lockprobe.study("flips", plant=f"twin?model={path}", **options))
    path.write_text(OWN.read_text("utf-8").replace("0.62", "0.6"), "utf-8")
    with pytest.raises(SettingsChanged, match=r"plant is 'twin\?model=.*digest="):
        claim(tmp_path / "S", lockprobe.study("flips", plant=f"twin?model={path}", **options))
    with pytest.raises(BadFile, match="another model: its digest is [0-9a-f]{16}, [0-9a-f]{16} was asked for"):
        resolve_plant(planned.plant).check(planned.box)
    path.unlink()
    assert resolve_plant(planned.plant).has_camera  # what was played can be read without the model


def test_a_model_that_breaks_the_rules_ends_before_the_first_trial(tmp_path):
    with pytest.raises(BadFile, match="expected one called 'revolute-left', as in the box"):
        lockprobe.run_trial(plant=SPEC, agent="random")
    path = written(tmp_path, OWN.read_text("utf-8").replace('size="0.015 0.064 0.01"', 'size="0.015 0.03 0.01"'))
    with pytest.raises(BadFile, match=r"in configuration 011 .* pin was pushed: .* of its travel from its ends"):
        resolve_plant(f"twin?model={path}").check(own_box())


def test_a_joint_between_its_ends_or_two_that_move_break_the_trial(monkeypatch):
    physical = plant()
    monkeypatch.setattr(physical._joints, "push", lambda joint: physical._joints.data.qpos.__setitem__(1, 0.04))
    with pytest.raises(PlantFault, match=r"joint 2 was pushed in 000; now: door 0.00, bar 0.50, pin 0.00"):
        physical.attempt(2)
    physical = plant()
    monkeypatch.setattr(physical._joints, "push", lambda joint: physical._joints.data.qpos.__setitem__(1, 0.08))
    with pytest.raises(PlantFault, match="another joint moved with joint 2: 000 became 010"):
        physical.attempt(2)


def test_without_a_panel_and_sites_the_world_and_the_parts_stand_in(tmp_path):
    text = "\n".join(line for line in OWN.read_text("utf-8").splitlines() if "<site" not in line)
    path = written(tmp_path, text.replace('body name="panel"', 'body name="table"'))
    frame = plant(settings=replace(CALM, model=str(path))).observe().look()
    assert frame.handles[1, 1] - frame.handles[1, 0] == pytest.approx([0.08, 0, 0], abs=1e-6)
    assert 0 < frame.handles[1, 0, 2] < 0.012  # the bar's centre of mass, in the world
