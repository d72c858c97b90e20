"""``lockprobe rig``: what it prints, and what it says where something is missing."""

import json

import pytest
from hardware import fakes
from lockprobe_robot.cli.rig import app
from lockprobe_robot.hardware import check
from typer.testing import CliRunner

from lockprobe.cli import build
from lockprobe.foundation.errors import UserMistake


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
