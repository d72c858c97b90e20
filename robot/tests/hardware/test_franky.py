"""The real client library against a simulated robot over loopback; skipped where they are not installed."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from builders import small_study
from hardware.wire_faults import BREAKING, FAULTS, MADE, SPEEDS

pytest.importorskip("franky")
pytest.importorskip("franky_sim")

from lockprobe_robot.arm.guarded_move import GuardedMove
from lockprobe_robot.hardware.bounds import Bounded
from lockprobe_robot.hardware.rehearsal import BOUNDS
from lockprobe_robot.hardware.rungs import parts_of

from lockprobe.boxes.families import box
from lockprobe.foundation.plugins import allow
from lockprobe.plants.operator import ConsentingOperator
from lockprobe.studies.running.runner import run_study

CHAIN = box("chain-4")


@pytest.fixture
def shown():
    return []


@pytest.fixture
def parts(shown):
    def film(model, data):
        shown.append([float(data.joint(f"arm-{number}").qpos[0]) for number in range(1, 8)])

    found = parts_of("wire", CHAIN, tuple("ABCD"), np.random.default_rng(1), film)
    yield found
    found.close()


def test_a_free_and_a_locked_joint_over_the_wire(parts, shown, monkeypatch):
    monkeypatch.setattr(parts.arm, "_wrench", replace(parts.arm._wrench, oldest=1.0))  # on a busy machine
    arm = Bounded(parts.arm, BOUNDS, ConsentingOperator())
    arm.home()
    for joint, verdict, after in ((3, "moved", (0, 0, 0, 1)), (0, "blocked", (0, 0, 0, 1))):
        touch = GuardedMove().attempt(arm, parts.path(joint, False))
        assert (touch.verdict, parts.state()) == (verdict, tuple(map(bool, after)))
    assert parts.arm.success_rate == 1.0
    assert parts.facts["driver"] == "franky-control 2.0.0"
    parts.roll()
    assert 25 * 5 < len(shown) < 25 * 60
    assert np.ptp(shown, axis=0).max() > 0.5  # radians: the film sees the arm go and come back
    assert shown[-1] == pytest.approx(shown[0], abs=0.1)


def wire_study(trials=1):
    study = small_study(["human-inspired"], p=[0.0], repetitions=1, trials=trials)
    allow(plant := "python:hardware.wire_faults:wire_rig")
    return replace(study, plant=plant, max_steps=1)


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_on_the_wire_stops_the_arm_and_the_trial_is_owed_again(name, tmp_path):
    fault = FAULTS[name]
    if fault.truth == "camera":
        pytest.importorskip("pyrealsense2")
    BREAKING[:], MADE[:], SPEEDS[:] = [name], [], []
    (trial,) = run_study(wire_study(), tmp_path)
    assert trial.error is not None
    ((arm, _),) = MADE
    told = [json.loads(line) for line in arm.log.last]
    first = next(at for at, line in enumerate(told) if line["command"] == "stop")
    took = told[first]["t"] - told[first - 1]["t"]
    print(f"{name}: told to stop {took:.2f} s after the last command, moves at {SPEEDS}: {trial.error.message}")
    assert (trial.ending, trial.error.boundary, trial.owed_again) == ("error", "plant", True)
    assert re.search(fault.why, trial.error.message)
    assert "\n" not in trial.error.message
    assert {line["command"] for line in told[first:]} <= {"stop", "stop failed"}
    assert took < 10
    assert [pytest.approx(0, abs=0.05)] * fault.alive == SPEEDS


def test_after_a_fault_the_same_command_plays_only_what_is_owed(tmp_path):
    MADE[:] = []
    BREAKING[:] = ["wrench stale"]
    study = wire_study(trials=2)
    broken, fine = run_study(study, tmp_path)
    assert (broken.ending, fine.ending) == ("error", "budget")
    again = {trial.key: trial for trial in run_study(study, tmp_path)}
    assert (again[broken.key].ending, again[fine.key], len(MADE)) == ("budget", fine, 3)
