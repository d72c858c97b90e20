"""An arm within bounds: what leaves them stops it first, and is said in one line."""

import itertools
import json

import numpy as np
import pytest
from hardware.fakes import SPACE, StoppableFake, Willing
from lockprobe_robot.arm.guarded_move import GuardedMove, HandlePath
from lockprobe_robot.hardware.bounds import Bounded, Bounds, CommandLog

from lockprobe.foundation.errors import BadFile, BadValue, PlantFault

DOWN = np.array([0.0, 0.0, -1.0])
STILL = np.zeros(3)
PATH = HandlePath(points=np.linspace((0.5, 0.0, 0.2), (0.5, 0.08, 0.2), 9), axis=DOWN)


def bounded(arm, operator=None, clock=None, log=None, **limits):
    clock = clock or (lambda: 0.0)
    return Bounded(arm, Bounds(**{**SPACE, **limits}), operator or Willing(), clock=clock, log=log)


def follow(arm, times):
    for _ in range(times):
        arm.follow(STILL, STILL, stiffness=1)


def test_within_its_bounds_an_arm_does_what_it_does_without_them():
    free, within = StoppableFake(), StoppableFake()
    expected = GuardedMove().attempt(free, PATH)
    arm = bounded(within)
    assert GuardedMove().attempt(arm, PATH) == expected
    assert within.log == free.log
    assert arm.stops == 0


def test_the_operator_agrees_before_the_first_motion_and_after_every_stop():
    fake, operator = StoppableFake(), Willing()
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
    fake = StoppableFake()
    with pytest.raises(PlantFault, match="the operator (did not agree to a motion|stopped)"):
        bounded(fake, operator).home()
    assert fake.log == ["stop"]


@pytest.mark.parametrize(
    ("command", "why"),
    [
        (lambda arm: arm.reach(np.array([0.0, 0.0, 1.2]), DOWN), "a pose at 0.000/0.000/1.200 m lies outside"),
        (lambda arm: arm.follow(np.array([0.0, 1.1, 0.0]), STILL, stiffness=1), "a target at 0.000/1.100/0.000 m lies"),
        (lambda arm: arm.follow(np.array([0.0, np.nan, 0.0]), STILL, stiffness=1), "a target at 0.000/nan/0.000 m"),
        (lambda arm: arm.follow(STILL, np.array([0.4, 0, 0]), stiffness=1), "a speed of 0.40 m/s was commanded, at m"),
    ],
)
def test_a_command_beyond_the_bounds_is_never_sent(command, why):
    fake = StoppableFake()
    with pytest.raises(PlantFault) as caught:
        command(bounded(fake))
    assert str(caught.value).startswith(why)
    assert fake.log == ["stop"]


@pytest.mark.parametrize(
    ("fake", "why"),
    [
        (StoppableFake(feel=lambda at, time: np.array([0, 0, 50.0 * (time > 1.02)])), "the hand feels 50.0 N, at most"),
        (StoppableFake(feel=lambda at, time: np.full(3, np.nan)), "the force is not a number"),
        (StoppableFake(follows=lambda point: np.array([0, 0, 3.0])), "the tool is at 0.000/0.000/3.000 m, outside"),
    ],
)
def test_what_is_measured_beyond_the_bounds_stops_the_arm(fake, why):
    arm = bounded(fake)
    arm.reach(STILL, DOWN)
    with pytest.raises(PlantFault, match=why):
        follow(arm, 5)
    assert fake.log[-1] == "stop"


def test_the_weight_of_the_hand_is_no_force():
    arm = bounded(StoppableFake(feel=lambda at, time: np.array([0.0, 0.0, -60.0])))
    arm.reach(STILL, DOWN)
    arm.follow(STILL, STILL, stiffness=1)
    assert arm.stops == 0


def test_a_program_that_stood_still_in_the_middle_of_a_move_is_stopped_and_between_moves_it_may():
    now = [0.0]
    fake = StoppableFake()
    arm = bounded(fake, clock=lambda: now[0])
    arm.follow(STILL, STILL, stiffness=1)
    now[0] = 100.0
    arm.home()  # the agent thought for a while
    now[0] = 200.0
    arm.follow(STILL, STILL, stiffness=1)
    now[0] = 200.7
    with pytest.raises(PlantFault, match="no command came for 0.70 s in the middle of a move, at most 0.5 s"):
        arm.follow(STILL, STILL, stiffness=1)
    assert fake.log == ["follow", "home", "follow", "stop"]


def test_late_commands_are_counted():
    ticks = itertools.accumulate(itertools.cycle([0.001, 0.03]))
    arm = bounded(StoppableFake(), clock=lambda: next(ticks))
    for _ in range(4):
        arm.follow(STILL, STILL, stiffness=1)
    assert arm.late == 4


def test_every_command_is_in_the_log(tmp_path):
    log = CommandLog(tmp_path / "commands.jsonl")
    arm = bounded(StoppableFake(), log=log)
    GuardedMove().attempt(arm, PATH)
    arm.stop()
    log.close()
    lines = [json.loads(line) for line in (tmp_path / "commands.jsonl").read_text().splitlines()]
    assert [line["command"] for line in lines[:2]] == ["reach", "follow"]
    assert [line["command"] for line in lines[-2:]] == ["home", "stop"]
    assert lines[0]["position"] == [0.5, 0.0, 0.25]
    with pytest.raises(BadFile, match="cannot be written"):
        CommandLog(tmp_path / "none" / "log")


@pytest.mark.parametrize("wrong", [{"high": (-2.0, 1.0, 1.0)}, {"speed": 0.0}, {"force": float("inf")}])
def test_senseless_bounds_are_refused(wrong):
    with pytest.raises(BadValue):
        Bounds(**{**SPACE, **wrong})


def test_an_arm_that_cannot_even_stop_is_said_in_the_log_and_hides_nothing():
    class Dead(StoppableFake):
        def home(self):
            raise ConnectionError("cable")

        def stop(self):
            raise ConnectionError("cable")

    arm = bounded(Dead())
    with pytest.raises(PlantFault, match="^the arm, home: ConnectionError: cable$"):
        arm.home()
    assert '"stop failed", "why": "stop: ConnectionError: cable"' in arm.log.last[-1]
