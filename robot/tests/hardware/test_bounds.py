"""An arm within bounds: what leaves them stops it first, and is said in one line."""

import itertools
import json
import threading

import numpy as np
import pytest
from arm.fake_arm import FakeArm
from hardware.fakes import SPACE, Willing
from lockprobe_robot.arm.guarded_move import HandlePath, guarded_move
from lockprobe_robot.hardware.bounds import Bounded, Bounds, DriverThread

from lockprobe.foundation.errors import BadFile, BadValue, PlantFault

DOWN = np.array([0.0, 0.0, -1.0])
STILL = np.zeros(3)
PATH = HandlePath(points=np.linspace((0.5, 0.0, 0.2), (0.5, 0.08, 0.2), 9), axis=DOWN)


def bounded(arm, operator=None, clock=None, log=None, **limits):
    clock = clock or (lambda: 0.0)
    return Bounded(arm, Bounds(**{**SPACE, **limits}), operator or Willing(), clock=clock, log=log)


def follow(arm, times=1, at=STILL, speed=STILL):
    for _ in range(times):
        arm.follow(np.array(at), np.array(speed), stiffness=1)


def test_within_its_bounds_an_arm_does_what_it_does_without_them():
    free, within = FakeArm(), FakeArm()
    arm = bounded(within, clock=itertools.count(0.0, 0.03).__next__)
    assert guarded_move(arm, PATH) == guarded_move(free, PATH)
    assert within.log == free.log
    assert (arm.stops, arm.late) == (0, free.log.count("follow"))


def test_the_operator_agrees_before_the_first_motion_and_after_every_stop():
    fake, operator = FakeArm(), Willing()
    arm = bounded(fake, operator)
    arm.home()
    arm.home()
    assert len(operator.questions) == 1
    arm.stop()
    arm.home()
    assert len(operator.questions) == 2
    assert fake.log == ["home", "home", "stop", "home"]


@pytest.mark.parametrize("operator", [Willing("n"), Willing(stops_after=0)])
def test_without_consent_nothing_moves(operator):
    fake = FakeArm()
    with pytest.raises(PlantFault, match="the operator (did not agree to a motion|stopped)"):
        bounded(fake, operator).home()
    assert fake.log == ["stop"]


BEYOND = {
    "pose": (lambda arm: arm.reach(np.array([0.0, 0.0, 1.2]), DOWN), "a pose is at 0.000/0.000/1.200 m, outside"),
    "target": (lambda arm: follow(arm, at=(0.0, 1.1, 0.0)), "a target is at 0.000/1.100/0.000 m, outside"),
    "no number": (lambda arm: follow(arm, at=(0.0, np.nan, 0.0)), "a target is at 0.000/nan/0.000 m"),
    "speed": (lambda arm: follow(arm, speed=(0.4, 0, 0)), "a speed of 0.40 m/s was commanded, at most"),
}


@pytest.mark.parametrize(("command", "why"), BEYOND.values(), ids=BEYOND)
def test_a_command_beyond_the_bounds_is_never_sent(command, why):
    fake = FakeArm()
    with pytest.raises(PlantFault, match=why):
        command(bounded(fake))
    assert fake.log == ["stop"]


MEASURED = {
    "force": (FakeArm(feel=lambda at, time: np.array([0, 0, 50.0 * (time > 1.02)])), "the hand feels 50.0 N, at most"),
    "no number": (FakeArm(feel=lambda at, time: np.full(3, np.nan)), "the force is not a number"),
    "place": (FakeArm(follows=lambda point: np.array([0, 0, 3.0])), "the tool is at 0.000/0.000/3.000 m, outside"),
}


@pytest.mark.parametrize(("fake", "why"), MEASURED.values(), ids=MEASURED)
def test_what_is_measured_beyond_the_bounds_stops_the_arm(fake, why):
    arm = bounded(fake)
    arm.reach(STILL, DOWN)
    with pytest.raises(PlantFault, match=why):
        follow(arm, 5)
    assert fake.log[-1] == "stop"


def test_a_program_that_stood_still_in_the_middle_of_a_move_is_stopped_and_between_moves_it_may():
    now = [0.0]
    fake = FakeArm()
    arm = bounded(fake, clock=lambda: now[0])
    follow(arm)
    now[0] = 100.0
    arm.home()  # the agent thought for a while
    now[0] = 200.0
    follow(arm)
    now[0] = 200.7
    with pytest.raises(PlantFault, match="no command came for 0.70 s in the middle of a move, at most 0.5 s"):
        follow(arm)
    assert fake.log == ["follow", "home", "follow", "stop"]


def test_every_command_is_in_the_log_also_a_stop_that_fails(tmp_path):
    class Dead(FakeArm):
        def stop(self):
            raise ConnectionError("cable")

    arm = bounded(Dead(), log=tmp_path / "commands.jsonl")
    guarded_move(arm, PATH)
    arm.close()
    lines = [json.loads(line) for line in (tmp_path / "commands.jsonl").read_text().splitlines()]
    assert [line["command"] for line in lines[:2]] == ["reach", "follow"]
    assert [line["command"] for line in lines[-3:]] == ["home", "stop", "stop failed"]
    assert (lines[0]["position"], lines[-1]["why"]) == ([0.5, 0.0, 0.25], "stop: ConnectionError: cable")
    with pytest.raises(BadFile, match="cannot be written"):
        bounded(FakeArm(), log=tmp_path / "none" / "log")


@pytest.mark.parametrize("wrong", [{"high": (-2.0, 1.0, 1.0)}, {"speed": 0.0}, {"force": float("inf")}])
def test_senseless_bounds_are_refused(wrong):
    with pytest.raises(BadValue):
        Bounds(**{**SPACE, **wrong})


def test_a_call_that_hangs_is_given_up_keeps_nobody_alive_and_none_is_made_after_it():
    thread, release = DriverThread(), threading.Event()
    assert thread.call("it", threading.current_thread, 5).daemon
    with pytest.raises(PlantFault, match="^the arm: no answer within 0.05 s$"):
        thread.call("the arm", release.wait, 0.05)
    with pytest.raises(PlantFault, match="an earlier call hangs"):
        thread.call("the arm", lambda: 1, 5)
    release.set()
