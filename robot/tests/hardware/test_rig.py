"""A rig of scripted parts: it obeys the contract of plants, and any fault stops the arm first."""

import re
import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from builders import small_study
from drawn_board import HANDLES, HEIGHT, WIDTH
from hardware import fakes
from hardware.fakes import SPACE, Breaking, DrawnCamera, Willing
from lockprobe_robot.box_model.panel import lay_out_panel
from lockprobe_robot.hardware import realsense
from lockprobe_robot.hardware.board import Board
from lockprobe_robot.hardware.bounds import Bounded, Bounds
from lockprobe_robot.hardware.position_reader import ImageHandles
from lockprobe_robot.hardware.rig import Eye, Rig
from lockprobe_robot.hardware.scripted_arm import ScriptedArm
from lockprobe_robot.hardware.wrench import FreshWrench, WrenchReading
from plants.person import handles_text

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import PlantFault, UserMistake
from lockprobe.foundation.plugins import allow
from lockprobe.plants.operator import ConsentingOperator
from lockprobe.studies.running.runner import Limits, run_study
from lockprobe.testing import check_plant

DOCS = Path(__file__).parents[2] / "docs"

FIVE = box("random-5-3")


def rig_of(box, labels=("A", "B", "C", "D", "E"), *, truth="verdict", operator=None, at=10**9, instead=None, **limits):
    """The rig, its arm and its camera."""
    path = lay_out_panel(box).handle_path
    arm = Breaking(box, path, at=at, instead=instead or (lambda arm: None))
    camera = DrawnCamera(arm)
    eye = Eye(camera=camera, handles=ImageHandles(size=(WIDTH, HEIGHT), places=HANDLES[: len(box.joints)]))
    within = Bounded(arm, Bounds(**{**SPACE, "answer": 60.0, **limits}), operator or Willing())
    eye = eye if truth == "camera" else None
    labels = labels[: len(box.joints)]
    rig = Rig(
        box, labels=labels, arm=within, path=path, operator=within._operator, eye=eye, truth=truth, rung="scripted"
    )
    return rig, arm, camera


@pytest.mark.parametrize(("truth", "boxes"), [("verdict", ["chain-4", "bichain-4"]), ("camera", [FIVE])])
def test_a_rig_fulfils_the_contract_of_plants(truth, boxes):
    check_plant(lambda box, labels, rng: rig_of(box, labels, truth=truth)[0], boxes=boxes, attempts=6)


def test_the_record_says_where_the_truth_comes_from_and_how_real_it_is():
    rig, _, _ = rig_of(box("chain-4"))
    rig.observe()
    seen = rig.attempt(3)
    assert (seen.outcome, seen.sensed["verdict"], seen.sensed["truth"]) == ("moved", "moved", "verdict")
    assert rig.facts["rung"] == "scripted"
    assert rig.facts["truth"] == "verdict"
    assert rig.facts["stops"] == 0


def test_a_person_who_contradicts_the_robot_is_believed_and_both_are_recorded():
    rig, _, _ = rig_of(box("chain-4"), truth="person", operator=Willing("", "y", "n"))
    rig.observe()
    seen = rig.attempt(3)
    assert (seen.outcome, seen.sensed["verdict"], seen.sensed["truth"]) == ("blocked", "moved", "person")
    assert seen.configuration == (False,) * 4


def test_a_failed_verdict_is_no_truth():
    """Nothing is pretended: where nobody knows, the trial breaks."""
    rig, arm, _ = rig_of(box("chain-4"))
    rig.observe()
    arm.configuration = (False, False, False, True)  # the handle is elsewhere, and the hand grips nothing
    arm.position = lambda: np.zeros(3)
    with pytest.raises(PlantFault, match=r"D \(revolute-right\): the robot's verdict is failed"):
        rig.attempt(3)
    assert arm.log == ["stop"]


def test_a_box_that_does_not_stand_as_it_should_is_asked_for_again():
    operator = Willing()
    rig, arm, _ = rig_of(FIVE, truth="camera", operator=operator)
    wrong, right = tuple(not at for at in FIVE.initial), FIVE.initial
    arm.configuration = wrong
    operator.tell = lambda line: (
        operator.told.append(line),
        setattr(arm, "configuration", right if "sees" in line else wrong),
    )
    assert rig.observe().configuration == right
    assert len([line for line in operator.told if line.startswith("The camera sees 11111, expected 00000")]) == 1


def test_where_nobody_can_set_the_box_up_a_wrong_one_ends_the_run():
    rig, arm, _ = rig_of(FIVE, truth="camera", operator=ConsentingOperator())
    arm.configuration = tuple(not at for at in FIVE.initial)
    with pytest.raises(UserMistake, match="the box does not stand as it should, and nobody is there to set it up"):
        rig.observe()
    assert arm.log == ["stop"]


def raising(error):
    def broken(*_):
        raise error

    return broken


STALE = FreshWrench(reader=type("Old", (), {"read": lambda self: WrenchReading(force=np.zeros(3), age=0.3)})())

FAULTS = {
    "client killed": ({"at": 30, "instead": raising(ConnectionResetError("peer"))}, "ConnectionResetError: peer"),
    "server killed": ({"at": 30, "instead": raising(BrokenPipeError(32, "gone"))}, "BrokenPipeError"),
    "frozen": ({"at": 30, "instead": lambda arm: threading.Event().wait(60), "answer": 0.1}, "no answer within 0.1 s"),
    "wrench stale": ({"at": 30, "instead": lambda arm: STALE.force(np.eye(3))}, "the wrench is 300 ms old"),
    "workspace left": ({"high": (1.0, 1.0, 0.2)}, "lies outside the workspace"),
    "force limit": ({"force": 2.0}, "the hand feels 3.0 N, at most 2 N"),
    "speed limit": ({"speed": 0.05}, "at most 0.05 m/s"),
}


@pytest.mark.parametrize(("parts", "why"), FAULTS.values(), ids=FAULTS)
def test_a_fault_in_a_move_stops_the_arm_before_anything_else(parts, why):
    """The connection frozen for 60 s costs no more than the longest answer."""
    rig, arm, _ = rig_of(box("chain-4"), **parts)
    rig.observe()
    with pytest.raises(PlantFault) as caught:
        rig.attempt(3)
    assert why in str(caught.value)
    assert "\n" not in str(caught.value)
    assert arm.log[-1] == "stop"
    assert "broke" not in arm.log or arm.log[1] == "stop"


def test_a_camera_that_is_gone_stops_the_arm():
    rig, arm, camera = rig_of(FIVE, truth="camera")
    rig.observe()
    camera.broken = raising(RuntimeError("No device connected"))
    with pytest.raises(PlantFault, match="^the camera: RuntimeError: No device connected$"):
        rig.attempt(0)
    assert arm.log == ["stop"]
    rig.close()
    assert camera.closed


def test_an_operator_who_says_no_is_a_fault_and_one_who_stops_before_the_trial_ends_the_run():
    rig, arm, _ = rig_of(box("chain-4"), operator=Willing("", "n"))
    with pytest.raises(PlantFault, match="the operator did not agree to a motion"):
        rig.observe()
    assert set(arm.log) == {"stop"}
    with pytest.raises(UserMistake, match="no trial had begun"):
        rig_of(box("chain-4"), operator=Willing(stops_after=0))[0].observe()


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


def test_the_example_of_the_docs_is_a_rig(monkeypatch):
    pytest.importorskip("mujoco")
    page = (DOCS / "robot.md").read_text("utf-8")
    text = next(one for one in re.findall(r"^```py\n(.*?)^```$", page, re.DOTALL | re.MULTILINE) if "Rig(" in one)
    puzzle = box("chain-4")
    lab = {}
    exec(compile(text.replace('Path("commands.jsonl")', ""), "lab.py", "exec"), lab)
    lab["TerminalOperator"] = lambda: Willing("", "y", "y")
    board = Board(panel=lay_out_panel(puzzle))
    lab["calibrated_board"] = lambda box, path: board
    lab["FrankyArm"] = lambda host, tool: ScriptedArm(puzzle, board.panel.handle_path)
    plant = lab["rig"](box=puzzle, labels=tuple("ABCD"), rng=None)
    assert plant.observe().configuration == puzzle.initial
    seen = plant.attempt(3)
    assert (seen.outcome, seen.sensed["verdict"], plant.facts["truth"]) == ("moved", "moved", "person")


def test_the_camera_of_the_docs_is_the_eye_of_a_rig(tmp_path, monkeypatch):
    page = (DOCS / "robot.md").read_text("utf-8")
    text = next(one for one in re.findall(r"^```py\n(.*?)^```$", page, re.DOTALL | re.MULTILINE) if "Eye(" in one)
    (tmp_path / "handles.toml").write_text(handles_text(FIVE), "utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(realsense, "RealSense", lambda: "camera")
    lab = {"box": FIVE, "Path": Path}
    exec(compile(text, "lab.py", "exec"), lab)
    assert isinstance(lab["eye"], Eye)
    assert (lab["eye"].camera, lab["eye"].handles.places) == ("camera", HANDLES)


def test_another_joint_that_moved_too_is_a_fault():
    rig, arm, _ = rig_of(FIVE, truth="camera")
    rig.observe()
    arm.home = lambda: setattr(arm, "configuration", (True,) * 5)
    with pytest.raises(PlantFault, match="was attempted and .* moved: 00000 became 11111"):
        rig.attempt(0)
