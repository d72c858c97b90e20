"""Rehearsals: every rung makes the same attempts, and what it says is what the rules say."""

import numpy as np
import pytest
from lockprobe_robot.hardware import rehearsal
from lockprobe_robot.hardware.rehearsal import RehearsedAttempt, parts_of, rehearse

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadValue
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.studies.running.single import run_trial
from lockprobe.testing import check_plant

CHAIN = box("chain-4")


@pytest.mark.parametrize("name", ["chain-4", "random-6-3"])
def test_the_scripted_rung_says_what_the_rules_say(name):
    found = rehearse("scripted", box(name), attempts=8, seed=2)
    assert (found.right, len(found.attempts)) == (8, 8)
    assert {one.free for one in found.attempts} == {True, False}


def test_the_twin_makes_the_same_attempts_and_agrees():
    pytest.importorskip("mujoco")
    scripted, twin = (rehearse(rung, box("chain-4"), attempts=4, seed=3) for rung in ("scripted", "twin"))
    assert [(one.state, one.joint, one.verdict) for one in scripted.attempts] == [
        (one.state, one.joint, one.verdict) for one in twin.attempts
    ]
    assert twin.right == 4


def test_after_a_fault_new_parts_take_over_and_the_fault_is_counted(monkeypatch):
    made = []

    def broken_once(rung, puzzle, labels, rng):
        made.append(parts_of(rung, puzzle, labels, rng))
        if len(made) == 1:
            made[0].arm.force = lambda: 1 / 0
        return made[-1]

    monkeypatch.setattr(rehearsal, "parts_of", broken_once)
    found = rehearse("scripted", box("chain-4"), attempts=3)
    assert found.attempts[0].fault == "the arm, force: ZeroDivisionError: division by zero"
    assert (len(made), found.right, made[0].arm.stops > 0) == (2, 2, True)


def test_right_needs_the_verdict_and_the_truth():
    one = RehearsedAttempt(state="0000", joint="a", free=True, verdict="moved", true=True)
    assert one.right
    assert not RehearsedAttempt(state="0000", joint="a", free=False, verdict="moved", true=True).right
    assert not RehearsedAttempt(state="0000", joint="a", free=True, verdict="moved", true=False).right
    assert not RehearsedAttempt(state="0000", joint="a", free=True, fault="gone").right


def test_a_rehearsal_is_a_plant_with_the_steps_of_the_rules():
    check_plant("rig?rung=scripted", boxes=["chain-4"], attempts=8)
    rehearsed, ruled = (
        run_trial(agent="human-inspired", p=0.4, seed=5, plant=plant) for plant in ("rig?rung=scripted", "symbolic")
    )
    assert rehearsed.actions == ruled.actions
    assert [step.told for step in rehearsed.steps] == [step.told for step in ruled.steps]
    assert (rehearsed.plant["rung"], rehearsed.plant["truth"]) == ("scripted", "simulation")
    assert {step.sensed["truth"] for step in rehearsed.steps} == {"simulation"}


def test_a_film_of_the_twins_rung_sees_the_arm_move():
    pytest.importorskip("mujoco")
    assert resolve_plant("rig?rung=scripted").make_filmed is None
    tool = []
    rig = resolve_plant("rig?rung=twin").make_filmed(
        CHAIN, tuple("ABCD"), np.random.default_rng(2), lambda model, data: tool.append(data.qpos.copy())
    )
    rig.observe()
    rig.attempt(0)
    seconds = rig.facts["rung"] == "twin" and len(tool) / 25
    rig.close()
    assert seconds > 3
    assert np.ptp(tool, axis=0).max() > 0.2  # radians of an arm's joint


def test_there_is_no_other_rung():
    with pytest.raises(BadValue, match="expected one of scripted, twin"):
        parts_of("robot", box("chain-4"), tuple("ABCD"), None)
