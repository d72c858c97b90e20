"""``lockprobe rig``: what it prints, and what it says where something is missing."""

import json

import numpy as np
import pytest
from hardware import fakes
from lockprobe_robot.cli.rig import app
from lockprobe_robot.hardware import arm_check, franky, rehearsal
from lockprobe_robot.hardware.rehearsal import parts_of
from typer.testing import CliRunner

from lockprobe.boxes.families import box
from lockprobe.cli import build
from lockprobe.foundation.errors import Missing, PlantFault, UserMistake


def run(*words):
    return CliRunner().invoke(app, words)


def test_a_rehearsal_prints_every_attempt_its_rung_and_a_count():
    done = run("rehearse", "--attempts", "4")
    lines = done.stdout.splitlines()
    assert done.exit_code == 0
    assert [line.split()[1:3] for line in lines[:2]] == [["revolute-left", "free"], ["slider-1", "free"]]
    assert lines[4:] == [
        "Rung: scripted, an arm without a body",
        "Agrees with the rules: 4 of 4 attempts on chain-4; 0 faults",
        "Late commands: 0",
    ]
    found = json.loads(run("rehearse", "--attempts", "4", "--json").stdout)
    assert (found["rung"], found["right"], len(found["attempts"])) == ("scripted", 4, 4)


def test_a_wrong_verdict_is_marked_and_sets_the_exit_status(monkeypatch):
    monkeypatch.setattr("lockprobe_robot.hardware.scripted_arm._HELD", 2.0)  # a locked handle that is hardly felt
    done = run("rehearse", "--attempts", "4")
    assert done.exit_code == 1
    assert "locked  failed" in done.stdout
    assert "<- WRONG" in done.stdout
    assert "late" not in done.stdout.splitlines()[-2]


def test_a_fault_is_no_wrong_verdict_and_late_commands_are_named_as_its_cause(monkeypatch):
    move = rehearsal.GuardedMove.attempt

    def slow(self, arm, path):
        if arm.late:
            raise PlantFault("the hand feels 41.5 N, at most 40 N")
        arm.late += 1
        return move(self, arm, path)

    monkeypatch.setattr(rehearsal.GuardedMove, "attempt", slow)
    done = run("rehearse", "--attempts", "2")
    lines = done.stdout.splitlines()
    assert done.exit_code == 1
    assert lines[1].endswith("fault: the hand feels 41.5 N, at most 40 N")
    assert "WRONG" not in done.stdout
    assert lines[-1] == "This machine was late, which alone can cause faults: run it again without other load."


def test_a_check_names_its_arm_and_its_judgement(monkeypatch):
    """Of the scripted arm in place of a robot."""
    scripted = parts_of("scripted", box("chain-4"), tuple("ABCD"), np.random.default_rng(0))
    scripted.arm.reach(np.array([0.5, 0.0, 0.4]), np.array([0.0, 0.0, -1.0]))
    monkeypatch.setattr(franky, "FrankyArm", lambda host: scripted.arm)
    monkeypatch.setattr("lockprobe.plants.operator.TerminalOperator", fakes.Willing)
    lines = run("check", "lab", "--commands", "20").stdout.splitlines()
    assert lines[0] == "Arm: FR3 at lab"
    assert lines[-1] == "Good enough to move."
    monkeypatch.setattr(arm_check, "MOST_DRIFT", -1.0)
    done = run("check", "lab", "--commands", "20")
    assert done.exit_code == 1
    assert done.stdout.splitlines()[-1] == "Not good enough: the tool drifted by 0.0 mm, at most -1000 mm."


def test_a_rehearsal_in_the_twin_names_its_engine():
    pytest.importorskip("mujoco")
    lines = run("rehearse", "--rung", "twin", "--attempts", "1").stdout.splitlines()
    assert lines[1].startswith("Rung: twin, the simulated arm, in this process; engine: mujoco ")


def test_a_dry_run_prints_every_motion_and_its_rung():
    done = run("dry-run", "--plant", "rig?rung=scripted", "--height", "0.08")
    lines = done.stdout.splitlines()
    assert done.exit_code == 0
    assert len(lines) == 11
    assert lines[0].split()[:5] == ["revolute-left", "0", "to", "1", "moved,"]
    assert lines[8] == "Rung: dry-run, 80 mm above the handles of chain-4; arm: scripted"
    assert lines[9] == "Free: 8 of 8 motions; greatest force 0.0 N; 0 late commands"
    assert lines[10] == (
        "Off by: along the handles' paths the hand was at most 0.0 mm from where it was told to be. "
        "Do not touch the board above 7 mm."
    )
    found = json.loads(run("dry-run", "--plant", "rig?rung=scripted", "--json").stdout)
    assert (found["rung"], found["facts"]["rung"], found["height"]) == ("dry-run", "scripted", 0.1)
    assert (len(found["motions"]), found["complaints"]) == (8, [])


def test_a_dry_run_of_a_laboratorys_rig_asks_its_operator(monkeypatch):
    monkeypatch.setattr(fakes, "CALIBRATION", {"path": "none.json"})
    monkeypatch.setattr(fakes, "BROKEN", [])
    error = run("dry-run", "--plant", "python:hardware.fakes:calibrated_rig").exception
    assert isinstance(error, UserMistake)
    assert "none.json" in str(error)
    error = run("dry-run", "--plant", "python:hardware.fakes:faulty_rig").exception
    assert isinstance(error, UserMistake)
    assert str(error) == "the arm, follow: ConnectionResetError: cable"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["dry-run", "--plant", "symbolic"], "plant: got 'symbolic', expected rig?rung="),
        (["dry-run", "--plant", "rig?rung=scripted", "--height", "1"], "height: got 1.0, expected metres from 0.05"),
        (["rehearse", "--box", "nothing"], "no box is called 'nothing'"),
    ],
)
def test_mistakes_are_one_line(words, message):
    error = run(*words).exception
    assert isinstance(error, UserMistake)
    assert str(error).startswith(message)


def test_without_the_library_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "franky", None)
    error = run("check", "h").exception
    assert isinstance(error, Missing)
    assert "lockprobe-robot[fr3]" in str(error)


def test_it_is_a_command():
    assert {one.name for one in build(["rig"]).registered_groups} == {"rig"}
