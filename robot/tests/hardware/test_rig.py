"""A rig of scripted parts: it obeys the contract of plants, and any fault stops the arm first; its check and rehearsal."""

import hashlib
import json
import re
import threading
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from builders import small_study
from hardware import fakes
from hardware.fakes import Willing, rig_of
from lockprobe_robot.arm.guarded_move import HELD_STIFFNESS
from lockprobe_robot.box_model.panel import lay_out_panel
from lockprobe_robot.box_model.tag_layout import board_checksum
from lockprobe_robot.calibration.calibration_file import Calibration
from lockprobe_robot.cli.rig import app
from lockprobe_robot.hardware import check, realsense
from lockprobe_robot.hardware.check import check_rig
from lockprobe_robot.hardware.rehearsal import ConsentingOperator
from lockprobe_robot.hardware.scripted_arm import ScriptedArm
from lockprobe_robot.hardware.sight import CameraSight
from plants.person import handles_text
from typer.testing import CliRunner

from lockprobe.boxes.families import box
from lockprobe.cli import build
from lockprobe.foundation.errors import BadFile, BadValue, PlantFault, UserMistake
from lockprobe.foundation.plugins import allow
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.studies.running.runner import Limits, run_study
from lockprobe.studies.running.single import run_trial
from lockprobe.testing import check_plant

PAGE = (Path(__file__).parents[2] / "docs" / "robot.md").read_text("utf-8")
CODE = re.findall(r"^```py\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE)
CHAIN, FIVE = box("chain-4"), box("random-5-3")


@pytest.mark.parametrize(("truth", "boxes"), [("verdict", ["chain-4", "bichain-4"]), ("camera", [FIVE])])
def test_a_rig_fulfils_the_contract_of_plants(truth, boxes):
    check_plant(lambda box, labels, rng: rig_of(box, labels, truth=truth)[0], boxes=boxes, attempts=6)


def begun(puzzle=CHAIN, **parts):
    rig, arm, camera = rig_of(puzzle, **parts)
    rig.observe()
    return rig, arm, camera


@pytest.mark.parametrize(
    ("parts", "outcome", "truth"),
    [({}, "moved", "verdict"), ({"truth": "person", "operator": Willing("", "y", "n")}, "blocked", "person")],
)
def test_the_record_says_where_the_truth_comes_from_and_a_person_who_contradicts_the_robot_is_believed(
    parts, outcome, truth
):
    rig, _, _ = begun(**parts)
    seen = rig.attempt(3)
    assert (seen.outcome, seen.sensed["verdict"], seen.sensed["truth"]) == (outcome, "moved", truth)
    assert (rig.facts["rung"], rig.facts["truth"], rig.facts["stops"]) == ("scripted", truth, 0)


def test_a_box_that_does_not_stand_as_it_should_is_asked_for_again_and_ends_the_run_where_nobody_can():
    wrong, operator = tuple(not at for at in FIVE.initial), Willing()
    rig, arm, _ = rig_of(FIVE, truth="camera", operator=operator)
    arm.configuration = wrong
    operator.tell = lambda line: setattr(
        arm, "configuration", FIVE.initial if "sees 11111, expected" in line else wrong
    )
    assert rig.observe().configuration == FIVE.initial
    rig, arm, _ = rig_of(FIVE, truth="camera", operator=ConsentingOperator())
    arm.configuration = wrong
    with pytest.raises(UserMistake, match="the box does not stand as it should, and nobody is there to set it up"):
        rig.observe()
    assert arm.log == ["stop"]


def raising(error):
    def broken(*_):
        raise error

    return broken


def elsewhere(arm, camera):
    arm.configuration = (False, False, False, True)  # the handle is elsewhere, and the hand grips nothing
    arm.position = lambda: np.zeros(3)


def gone(arm, camera):
    camera.broken = raising(RuntimeError("No device connected"))


def all_moved(arm, camera):
    arm.home = lambda: setattr(arm, "configuration", (True,) * 5)


LOST, FROZEN = raising(ConnectionResetError("peer")), lambda arm: threading.Event().wait(60)
FAULTS = {
    "client killed": ({"at": 30, "instead": LOST}, None, "ConnectionResetError: peer"),
    "frozen for 60 s": ({"at": 30, "instead": FROZEN, "answer": 0.1}, None, "no answer within 0.1 s"),
    "force limit": ({"force": 2.0}, None, "the hand feels 3.0 N, at most 2 N"),
    "nobody knows": ({}, elsewhere, r"D \(revolute-right\): the robot's verdict is failed"),
    "camera gone": ({"puzzle": FIVE, "truth": "camera"}, gone, "^the camera: RuntimeError: No device connected$"),
    "others moved": ({"puzzle": FIVE, "truth": "camera"}, all_moved, "was attempted and .*: 00000 became 11111"),
}


@pytest.mark.parametrize(("parts", "breaks", "why"), FAULTS.values(), ids=FAULTS)
def test_a_fault_stops_the_arm_before_anything_else(parts, breaks, why):
    rig, arm, camera = begun(**parts)
    if breaks:
        breaks(arm, camera)
    with pytest.raises(PlantFault, match=why):
        rig.attempt(3)
    assert arm.log[-1] == "stop"
    assert "broke" not in arm.log[1:], "nothing is between the fault and the stop"
    rig.close()
    assert camera.closed == ("truth" in parts)


def test_in_a_study_a_fault_ends_the_trial_as_an_error_of_the_plant_and_it_is_played_again(tmp_path, monkeypatch):
    """In this process, whatever is asked of workers: the plant says that somebody attends it."""
    allow(plant := "python:hardware.fakes:faulty_rig")
    study = replace(small_study(["human-inspired"], p=[0.0], repetitions=1, trials=2), plant=plant)
    assert study.attended
    monkeypatch.setattr(fakes, "BROKEN", [])
    broken, fine = run_study(study, tmp_path, limits=Limits(workers=4))
    assert (broken.error.boundary, broken.error.message) == ("plant", "the arm, follow: ConnectionResetError: cable")
    assert broken.owed_again
    assert fine.solved
    assert fakes.BROKEN[0].log[:2] == ["broke", "stop"]
    again = {trial.key: trial for trial in run_study(study, tmp_path)}
    assert all(trial.solved for trial in again.values())
    assert again[fine.key] == fine


def test_the_example_of_the_docs_is_a_rig_and_its_camera_a_sight(tmp_path, monkeypatch):
    lab, panel = {}, lay_out_panel(CHAIN)
    text = next(one for one in CODE if "Rig(" in one).replace('log=Path("commands.jsonl")', "")
    exec(compile(text, "lab.py", "exec"), lab)
    lab["TerminalOperator"] = lambda: Willing("", "y", "y")
    lab["calibrated_board"] = lambda box, path: (panel, {})
    lab["FrankyArm"] = lambda host, tool: ScriptedArm(CHAIN, panel.handle_path)
    plant = lab["rig"](box=CHAIN, labels=tuple("ABCD"), rng=None)
    assert plant.observe().configuration == CHAIN.initial
    seen = plant.attempt(3)
    assert (seen.outcome, seen.sensed["verdict"], plant.facts["truth"]) == ("moved", "moved", "person")
    (tmp_path / "handles.toml").write_text(handles_text(FIVE), "utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(realsense, "RealSense", lambda: "camera")
    lab = {"box": FIVE, "Path": Path}
    exec(compile(next(one for one in CODE if "CameraSight(" in one), "lab.py", "exec"), lab)
    assert isinstance(lab["sight"], CameraSight)


POSE = ((0, 1, 0, 0.52), (-1, 0, 0, 0.03), (0, 0, 1, 0.17), (0, 0, 0, 1))
REFUSALS = {
    "coarse": (CHAIN, 4.2, "hold-out error 4.2 mm, but the arm tolerates 4 mm"),
    "other board": (box("random-6-3"), 1.0, "a calibration of another board .box random-6-3.: run lockprobe rig cal"),
    "fine": (CHAIN, 4.0, ""),
}


@pytest.mark.parametrize(("of", "held_out", "why"), REFUSALS.values(), ids=REFUSALS)
def test_a_study_starts_only_on_a_calibration_that_can_be_relied_on(tmp_path, of, held_out, why):
    """Else nothing is connected, nothing moves, and there is no study directory with a broken trial."""
    allow(plant := "python:hardware.fakes:calibrated_rig")
    study = replace(small_study(["human-inspired"], p=[0.0], repetitions=1, trials=1), plant=plant)
    path = fakes.CALIBRATION["path"] = tmp_path / "calibration.json"
    fakes.CONNECTED.clear()
    found = Calibration(
        date=datetime.now(UTC), box=of.name, board=board_checksum(lay_out_panel(of)), camera_in_hand=POSE,
        board_in_base=POSE, used=("0.png",), refused={}, turned_degrees=25.0, held_out_mm=held_out,
        held_out_worst_mm=9.0, reprojection_px=0.3,
    )  # fmt: skip
    path.write_text(found.model_dump_json())
    if not why:
        (played,) = run_study(study, tmp_path / "out")
        assert (played.error, played.plant["calibration_held_out_mm"]) == (None, held_out)
        assert played.plant["calibration_sha256"] == hashlib.sha256(path.read_bytes()).hexdigest()
        return
    with pytest.raises(BadFile, match=why):
        run_study(study, tmp_path / "out")
    assert (fakes.CONNECTED, (tmp_path / "out").exists()) == ([], False)


def test_a_check_makes_every_motion_at_its_height_after_a_yes_and_the_box_stays_as_it_is():
    operator, heights, told = Willing(), [], []
    rig, arm, _ = rig_of(CHAIN, operator=operator)
    path = lay_out_panel(CHAIN).handle_path(0, False)
    follow = arm.follow

    def noting(position, velocity, *, stiffness):
        heights.append(float((path.points[0] - position) @ path.axis))
        follow(position, velocity, stiffness=stiffness)
        if stiffness == HELD_STIFFNESS:
            arm._at = arm._at + np.array([0.003, 0, 0])

    arm.follow = noting
    assert check_rig(rig, tell=told.append) == []
    assert [(one.joint, one.start) for one in told] == [(name, at) for name in CHAIN.names for at in (0, 1)]
    assert len(operator.questions) == 1
    assert {one.verdict for one in told} == {"moved"}
    assert [one.astray for one in told] == pytest.approx([0.003] * 8)
    assert 0.09 < min(heights) < 0.101
    assert 0.14 < max(heights) < 0.155  # with the clearance of the guarded move
    assert (arm.configuration, rig.arm.commands) == (CHAIN.initial, len(heights))


def pushed(arm):
    arm.force = lambda: np.array([0.0, 11.0, -6.0])


def sunk(arm):
    where = arm.position
    arm.position = lambda: where() - np.array([0.0, 0.0, 0.06])


@pytest.mark.parametrize(
    ("breaks", "why"),
    [(pushed, "the hand feels 11.0 N where nothing is, at most 10 N"), (sunk, "mm above the handles, expected 100 mm")],
)
def test_what_should_not_be_above_the_board_stops_the_arm(breaks, why):
    rig, arm, _ = rig_of(CHAIN, at=20, instead=breaks)
    with pytest.raises(PlantFault, match=why):
        check_rig(rig, tell=print)
    assert (arm.log[-1], arm.calls) == ("stop", 20)  # nothing was commanded after it


def test_an_arm_that_receives_its_commands_late_is_complained_of():
    rig, _, _ = rig_of(CHAIN)
    rig._rung, rig.arm.late = "robot", 10**4
    (complaint,) = check_rig(rig, tell=print)
    assert complaint.endswith("commands were late, at most 1%")


def test_on_the_twin_verdicts_are_right_a_check_touches_nothing_and_it_can_be_filmed():
    (make, seen), short = (resolve_plant("rig?rung=twin").make_filmed, []), box("chain-2")
    rig = make(short, ("A", "B"), np.random.default_rng(1), lambda model, data: seen.append(data.qpos.copy()))
    told = []
    assert (check_rig(rig, tell=told.append), rig.observe().configuration) == ([], short.initial)
    assert max(one.force for one in told) < 5
    assert min(one.lowest for one in told) > 0.09
    for joint, said in ((0, "blocked"), (1, "moved")):
        snapshot = rig.attempt(joint)
        assert (snapshot.outcome, snapshot.sensed["verdict"]) == (said, said)
    assert (rig.facts["rung"], rig.facts["truth"]) == ("twin", "simulation")
    assert len(seen) > 150
    assert np.ptp(seen, axis=0).max() > 0.2  # radians of an arm's joint


def test_a_rehearsal_says_that_it_is_one():
    """That its steps are those of the rules is held where sources are."""
    rehearsed = run_trial(agent="human-inspired", max_steps=1, plant="rig?rung=scripted")
    assert (rehearsed.plant["rung"], rehearsed.plant["truth"]) == ("scripted", "simulation")
    with pytest.raises(BadValue, match="expected one of scripted, twin"):
        resolve_plant("rig?rung=robot")


def run(*words):
    return CliRunner().invoke(app, words)


def test_a_check_prints_every_motion_and_its_judgement(monkeypatch):
    done = run("check", "--plant", "rig?rung=scripted")
    lines = done.stdout.splitlines()
    assert (done.exit_code, len(lines)) == (0, 11)
    assert lines[0].split()[:5] == ["revolute-left", "0", "to", "1", "moved,"]
    assert lines[9:] == ["In free air: greatest force 0.0 N, off by at most 0.0 mm", "Good enough."]
    monkeypatch.setattr(check, "MOST_ASTRAY", -0.001)
    done = run("check", "--plant", "rig?rung=scripted", "--json")
    found = json.loads(done.stdout)
    assert (done.exit_code, found["facts"]["rung"], len(found["motions"])) == (1, "scripted", 8)
    assert found["complaints"][-1].startswith("revolute-right from 1: the hand was off by 0.0 mm")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["check", "--plant", "symbolic"], "plant: got 'symbolic', expected rig?rung="),
        (["check", "--plant", "python:hardware.fakes:calibrated_rig"], "none.json: cannot be read"),
        (["check", "--plant", "python:hardware.fakes:faulty_rig"], "the arm, follow: ConnectionResetError: cable"),
    ],
)
def test_mistakes_are_one_line(words, message, monkeypatch):
    monkeypatch.setattr(fakes, "CALIBRATION", {"path": "none.json"})
    monkeypatch.setattr(fakes, "BROKEN", [])
    error = run(*words).exception
    assert isinstance(error, UserMistake)
    assert str(error).startswith(message)
    assert {one.name for one in build(["rig"]).registered_groups} == {"rig"}
